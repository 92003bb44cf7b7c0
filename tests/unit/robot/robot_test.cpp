#include "robot/robot.h"

#include <gtest/gtest.h>
#include <mujoco/mujoco.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <memory>

#include "core/random.h"

namespace primo::robot {
namespace {

const std::filesystem::path kRobotFile =
    std::filesystem::path(PRIMO_SOURCE_DIR) / "configs/robots/schunk_lwa3_sdh2.yaml";

Robot schunk() {
  auto robot = Robot::load(kRobotFile);
  EXPECT_TRUE(robot.ok()) << (robot.ok() ? "" : robot.error().message);
  return std::move(robot).value();
}

Eigen::VectorXd random_q(const Robot& robot, std::uint64_t i) {
  Random random(1, "robot_test", {i});
  Eigen::VectorXd q(robot.joints());
  for (int j = 0; j < q.size(); ++j) q[j] = random.uniform(robot.lower()[j], robot.upper()[j]);
  return q;
}

/// The same robot in MuJoCo, as an independent reference.
struct Reference {
  explicit Reference(const Robot& robot)
      : model(mj_loadXML(robot.mjcf_path().c_str(), nullptr, nullptr, 0), &mj_deleteModel),
        data(mj_makeData(model.get()), &mj_deleteData) {}
  void set(const Robot& robot, const Eigen::VectorXd& q) {
    for (const auto& joint : robot.chain()) {
      const int id = mj_name2id(model.get(), mjOBJ_JOINT, joint.name.c_str());
      data->qpos[model->jnt_qposadr[id]] = joint.offset + joint.ratio * q[joint.index];
    }
    mj_kinematics(model.get(), data.get());
    mj_comPos(model.get(), data.get());
  }
  std::unique_ptr<mjModel, decltype(&mj_deleteModel)> model;
  std::unique_ptr<mjData, decltype(&mj_deleteData)> data;
};

/// A folder with a changed copy of the robot file (and of the model); gone with the object.
class Copy {
 public:
  Copy() : folder_(std::filesystem::temp_directory_path() / ("primo_robot_test_" + std::to_string(getpid()))) {
    std::filesystem::create_directories(folder_);
    for (const char* name : {"schunk_lwa3_sdh2.yaml", "schunk_lwa3_sdh2.xml"}) {
      std::filesystem::copy_file(kRobotFile.parent_path() / name, folder_ / name,
                                 std::filesystem::copy_options::overwrite_existing);
    }
  }
  ~Copy() { std::filesystem::remove_all(folder_); }
  void replace(const std::string& file, const std::string& from, const std::string& to) {
    std::string text = read_file(folder_ / file).value();
    const auto at = text.find(from);
    ASSERT_NE(at, std::string::npos) << from;
    text.replace(at, from.size(), to);
    std::ofstream(folder_ / file) << text;
  }
  std::string error() {
    auto robot = Robot::load(folder_ / "schunk_lwa3_sdh2.yaml");
    return robot.ok() ? "no error" : robot.error().message;
  }

 private:
  const std::filesystem::path folder_;
};

TEST(Robot, BodyPosesAgreeWithMuJoCo) {
  const Robot robot = schunk();
  Reference reference(robot);
  Kinematics kinematics;
  for (std::uint64_t i = 0; i < 200; ++i) {
    const Eigen::VectorXd q = random_q(robot, i);
    robot.forward(q, kinematics);
    reference.set(robot, q);
    for (std::size_t b = 0; b < robot.bodies().size(); ++b) {
      const Eigen::Map<const Eigen::Vector3d> p(reference.data->xpos + 3 * b);
      const Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>> R(reference.data->xmat + 9 * b);
      ASSERT_LT((kinematics.X_WB[b].translation() - p).norm(), 1e-9) << robot.bodies()[b].name;
      ASSERT_LT((kinematics.X_WB[b].linear() - R).norm(), 1e-9) << robot.bodies()[b].name;
    }
  }
}

TEST(Robot, PointJacobiansAgreeWithMuJoCo) {
  const Robot robot = schunk();
  Reference reference(robot);
  const int nv = reference.model->nv;
  for (std::uint64_t i = 0; i < 50; ++i) {
    const Eigen::VectorXd q = random_q(robot, i);
    const Kinematics kinematics = robot.forward(q);
    reference.set(robot, q);
    for (std::size_t b = 1; b < robot.bodies().size(); ++b) {
      const Eigen::Vector3d point = kinematics.X_WB[b] * Eigen::Vector3d(0.1, -0.2, 0.05);
      Eigen::Matrix<double, 3, Eigen::Dynamic, Eigen::RowMajor> theirs(3, nv);
      mj_jac(reference.model.get(), reference.data.get(), theirs.data(), nullptr, point.data(), static_cast<int>(b));
      Eigen::Matrix3Xd expected = Eigen::Matrix3Xd::Zero(3, robot.joints());
      for (const auto& joint : robot.chain()) {
        const int id = mj_name2id(reference.model.get(), mjOBJ_JOINT, joint.name.c_str());
        expected.col(joint.index) += joint.ratio * theirs.col(reference.model->jnt_dofadr[id]);
      }
      ASSERT_LT((robot.point_jacobian(kinematics, static_cast<int>(b), point) - expected).norm(), 1e-9);
    }
  }
}

TEST(Robot, VectorJacobiansAgreeWithCentralDifferences) {
  const Robot robot = schunk();
  const int body = robot.fingertips()[2].frame.body;
  const Eigen::Vector3d v_B(0.3, -0.5, 0.8);
  const Eigen::VectorXd q = random_q(robot, 7);
  const Kinematics kinematics = robot.forward(q);
  const Eigen::Matrix3Xd J = robot.vector_jacobian(kinematics, body, kinematics.X_WB[body].linear() * v_B);
  for (int j = 0; j < robot.joints(); ++j) {
    const Eigen::VectorXd step = 1e-5 * Eigen::VectorXd::Unit(robot.joints(), j);
    const Eigen::Vector3d slope =
        (robot.forward(q + step).X_WB[body].linear() * v_B - robot.forward(q - step).X_WB[body].linear() * v_B) / 2e-5;
    EXPECT_LT((J.col(j) - slope).norm(), 1e-8) << robot.joint_names()[j];
  }
}

TEST(Robot, GradientsAreRowsOfTheJacobians) {
  const Robot robot = schunk();
  const Kinematics kinematics = robot.forward(random_q(robot, 3));
  const int body = robot.grasp_frame().body;
  const Eigen::Vector3d point(0.5, 0.1, 0.9), weight(1, -2, 0.5);
  Eigen::RowVectorXd row = Eigen::RowVectorXd::Zero(robot.joints());
  robot.add_point_gradient(kinematics, body, point, weight, row);
  EXPECT_LT((row - weight.transpose() * robot.point_jacobian(kinematics, body, point)).norm(), 1e-12);
  row.setZero();
  robot.add_vector_gradient(kinematics, body, point, weight, row);
  EXPECT_LT((row - weight.transpose() * robot.vector_jacobian(kinematics, body, point)).norm(), 1e-12);
}

TEST(Robot, HasThePublishedDimensions) {
  const Robot robot = schunk();
  ASSERT_EQ(robot.joints(), 14);
  EXPECT_EQ(robot.arm_joints(), 7);
  // All angles zero: everything along the column's axis, tilted 15°, turned 25°.
  const Kinematics zero = robot.forward(Eigen::VectorXd::Zero(14));
  const Pose X_WG = robot.pose(zero, robot.grasp_frame());
  const double length = 0.12 + 2 * 0.175 + 2 * 0.1515 + 2 * 0.12575 + 0.32;
  const Eigen::Vector3d shoulder(0, 0.25, 0.85);
  EXPECT_NEAR((X_WG.translation() - shoulder).norm(), length, 1e-9);
  EXPECT_NEAR(X_WG.linear()(2, 2), std::cos(15 * M_PI / 180), 1e-9);
  for (const auto& tip : robot.fingertips()) {
    const Eigen::Vector3d p_GT = X_WG.inverse() * robot.pose(zero, tip.frame).translation();
    EXPECT_NEAR(p_GT.z(), 0.086 + 0.0865 + 0.035 - 0.2126, 1e-9) << tip.name;
    // Pads face the opposite side of the grasp frame's x axis.
    const Eigen::Vector3d n_G = X_WG.linear().transpose() * robot.pose(zero, tip.frame).linear().col(2);
    EXPECT_NEAR(n_G.x(), tip.thumb ? 1 : -1, 1e-9) << tip.name;
  }
}

TEST(Robot, SecondKnuckleTurnsByTheOppositeAngle) {
  const Robot robot = schunk();
  Eigen::VectorXd q = Eigen::VectorXd::Zero(14);
  const auto knuckle = std::find(robot.joint_names().begin(), robot.joint_names().end(), "knuckle");
  ASSERT_NE(knuckle, robot.joint_names().end());
  q[knuckle - robot.joint_names().begin()] = 0.7;
  const Kinematics kinematics = robot.forward(q);
  const Eigen::Matrix3d R_WP = kinematics.X_WB[robot.body("palm")].linear();
  const Eigen::Vector3d x2 = R_WP.transpose() * kinematics.X_WB[robot.body("finger_2_knuckle")].linear().col(0);
  const Eigen::Vector3d x3 = R_WP.transpose() * kinematics.X_WB[robot.body("finger_3_knuckle")].linear().col(0);
  EXPECT_NEAR(std::atan2(x2.y(), x2.x()), 0.7, 1e-12);
  EXPECT_NEAR(std::atan2(x3.y(), x3.x()), -0.7, 1e-12);
}

TEST(Robot, KnowsWhichLinksAreTheHandAndWhichMove) {
  const Robot robot = schunk();
  for (const auto& link : robot.link_shapes()) {
    const bool fixed = link.name == "base" || link.name == "column" || link.name == "mount";
    EXPECT_EQ(link.moves, !fixed) << link.name;
    EXPECT_EQ(link.hand, !fixed && link.name.rfind("link_", 0) != 0) << link.name;
  }
  for (const auto& tip : robot.fingertips()) {
    EXPECT_NE(robot.link_shapes()[tip.link_shape].name.find("distal"), std::string::npos);
  }
}

TEST(Robot, MissingJointIsRefusedWithTheJointsThatExist) {
  Copy copy;
  copy.replace("schunk_lwa3_sdh2.yaml", "joint: arm_3", "joint: arm_33");
  const std::string error = copy.error();
  EXPECT_NE(error.find("arm[2]"), std::string::npos) << error;
  EXPECT_NE(error.find("'arm_33'"), std::string::npos) << error;
  EXPECT_NE(error.find("arm_1, arm_2, arm_3"), std::string::npos) << error;
}

TEST(Robot, MissingBodyIsRefusedWithTheBodiesThatExist) {
  Copy copy;
  copy.replace("schunk_lwa3_sdh2.yaml", "body: palm", "body: plam");
  const std::string error = copy.error();
  EXPECT_NE(error.find("grasp_frame.body"), std::string::npos) << error;
  EXPECT_NE(error.find("thumb_distal"), std::string::npos) << error;
}

TEST(Robot, UnlistedJointIsRefused) {
  Copy copy;
  copy.replace("schunk_lwa3_sdh2.xml", "joint1=\"finger_3_knuckle\" joint2=\"knuckle\"",
               "joint1=\"finger_3_knuckle\" active=\"false\" joint2=\"knuckle\"");
  EXPECT_NE(copy.error().find("'finger_3_knuckle'"), std::string::npos) << copy.error();
}

TEST(Robot, HomeOutsideTheRangeIsRefused) {
  Copy copy;
  copy.replace("schunk_lwa3_sdh2.yaml", "home: 0.46", "home: 2.46");
  const std::string error = copy.error();
  EXPECT_NE(error.find("arm[0].home"), std::string::npos) << error;
  EXPECT_NE(error.find("2.46"), std::string::npos) << error;
}

TEST(Robot, MissingAndBrokenModelsAreRefusedWithTheirPath) {
  Copy copy;
  copy.replace("schunk_lwa3_sdh2.xml", "</mujoco>", "<broken/></mujoco>");
  EXPECT_NE(copy.error().find("schunk_lwa3_sdh2.xml"), std::string::npos) << copy.error();
  copy.replace("schunk_lwa3_sdh2.yaml", "mjcf: schunk", "mjcf: nowhere");
  EXPECT_NE(copy.error().find("nowhere_lwa3_sdh2.xml"), std::string::npos) << copy.error();
}

}  // namespace
}  // namespace primo::robot
