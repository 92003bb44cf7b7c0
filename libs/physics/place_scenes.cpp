#include "physics/place_scenes.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>

#include "core/random.h"
#include "physics/criteria.h"
#include "physics/execution.h"
#include "physics/joint_map.h"
#include "scene/geometry.h"
#include "scene/held.h"
#include "scene/reach.h"

namespace primo::physics {
namespace {

constexpr int kSceneTries = 40;  // whole scenes
constexpr int kGraspTries = 12;  // hand poses at one scene
constexpr int kArmTries = 6;     // joint angles of one hand pose
constexpr double kMostClosing = 1.5;

/// The grasp frame of a nominal grasp of an upright object: approach z at this heading from x and pitch below the
/// level, opposition x level, on either side.
Pose nominal_grasp(const Eigen::Vector3d& centre, double heading, double pitch, bool flipped) {
  Pose X = Pose::Identity();
  const Eigen::Vector3d z(std::cos(heading) * std::cos(pitch), std::sin(heading) * std::cos(pitch), -std::sin(pitch));
  const Eigen::Vector3d x = Eigen::Vector3d(-z.y(), z.x(), 0).normalized() * (flipped ? -1.0 : 1.0);
  X.linear() << x, z.cross(x), z;
  X.translation() = centre;
  return X;
}

/// The table scene with its target as the support c2, its other cylinders numbered from c3 and c1 added.
scene::Scenario with_held_object(scene::Scenario scenario, double radius, const Eigen::Vector3d& position) {
  for (auto& object : scenario.objects) {
    if (object.name[0] == 'c') object.name = "c" + std::to_string(std::stoi(object.name.substr(1)) + 1);
  }
  scene::Object held;
  held.name = "c1";
  held.radius = radius;
  held.position = position;
  scenario.objects.insert(scenario.objects.begin(), held);
  scenario.held = scene::Held{"c1"};
  scenario.action = {"place", "c1", "c2"};
  return scenario;
}

/// Whether the start keeps its margins. @pre robot_start and held are filled in.
bool good_start(const robot::Robot& robot, const PlaceSceneSettings& settings, const scene::Scenario& scenario) {
  const Eigen::VectorXd q = Eigen::Map<const Eigen::VectorXd>(scenario.robot_start.data(), robot.joints());
  const int arm = robot.arm_joints();
  const double margin = std::min((q - robot.lower()).head(arm).minCoeff(), (robot.upper() - q).head(arm).minCoeff());
  if (margin < settings.limit_margin || !scene::check_robot(scenario, robot).ok()) return false;
  auto pairs = clearance_pairs(scenario, "c1");
  for (auto& pair : target_pairs(scenario, "c1")) pairs.push_back(std::move(pair));
  ClearanceQuery query(robot, std::move(pairs), held_shape(robot, scenario));
  return query.at(q) >= settings.min_gap;
}

Eigen::Vector3d rpy_of(const Pose& X) { return X.linear().eulerAngles(2, 1, 0).reverse(); }

/// Writes X_GO and the pose that it gives c1 at robot_start. False when c1 leans.
bool hold_at(const robot::Robot& robot, const Pose& X_GO, scene::Scenario& scenario) {
  constexpr double kUpright = 0.05;  // rad
  scenario.held->position = X_GO.translation();
  scenario.held->rpy = rpy_of(X_GO);
  const Pose X_WO = scene::held_pose(scenario, robot);
  scenario.objects.front().position = X_WO.translation();
  scenario.objects.front().rpy = rpy_of(X_WO);
  return X_WO.linear()(2, 2) > std::cos(kUpright);
}

/// Takes fingers and X_GO from where the object is once the fingers press on it: closing fingers shift what they hold.
/// False when it does not stay.
bool settle(const robot::Robot& robot, scene::Scenario& scenario) {
  constexpr double kSettleSeconds = 0.2;
  JudgeRequest request;
  request.scenario = scenario;
  request.q.resize(1, robot.joints());
  for (int i = 0; i < robot.joints(); ++i) request.q(0, i) = scenario.robot_start[static_cast<std::size_t>(i)];
  auto model = assemble(&robot, scenario, {.timestep = request.settings.timestep, .extra = {}});
  if (!model.ok()) return false;
  Simulation simulation(robot, request, std::move(model).value(), "c1");
  if (!grip_held(simulation, request)) return false;
  const Eigen::VectorXd q0 = request.q.row(0).transpose();
  for (int k = simulation.steps_in(kSettleSeconds); k > 0; --k) {
    if (!simulation.step(at_rest(q0), Simulation::Fingers::hold, false)) return false;
  }
  simulation.update();
  const Eigen::VectorXd q = simulation.q();
  const Pose X_PG = palm_pose(robot, q).inverse(Eigen::Isometry) * robot.pose(robot.forward(q), robot.grasp_frame());
  const Pose X_GO = X_PG.inverse(Eigen::Isometry) * simulation.X_PO();
  for (int i = robot.arm_joints(); i < robot.joints(); ++i) scenario.robot_start[static_cast<std::size_t>(i)] = q[i];
  return hold_at(robot, X_GO, scenario);
}

/// Puts the robot's hand around c1 at X_WG; false when no start was found.
bool hold(const robot::Robot& robot, const PlaceSceneSettings& settings, const Pose& X_WG, Random& random,
          scene::Scenario& scenario) {
  scene::Object& object = scenario.objects.front();
  for (int k = 0; k < kArmTries; ++k) {
    Eigen::VectorXd q = robot.home();
    for (int i = 0; i < robot.arm_joints(); ++i) q[i] = random.uniform(robot.lower()[i], robot.upper()[i]);
    const auto reached = arm_to(robot, q, X_WG);
    if (!reached) continue;
    const Eigen::VectorXd closed = close_onto(robot, *reached, object.shape(), object.X_WO(), kMostClosing);
    scenario.robot_start.assign(closed.begin(), closed.end());
    const Pose X_WO = object.X_WO();
    const Pose X_GO = robot.pose(robot.forward(closed), robot.grasp_frame()).inverse(Eigen::Isometry) * X_WO;
    if (hold_at(robot, X_GO, scenario) && good_start(robot, settings, scenario) && settle(robot, scenario) &&
        good_start(robot, settings, scenario)) {
      return true;
    }
    object.position = X_WO.translation();
    object.rpy.setZero();
  }
  return false;
}

Status check(const PlaceSceneSettings& settings) {
  if (settings.min_distance <= settings.max_distance && settings.min_lift <= settings.max_lift) return success();
  return Error{Code::config,
               "random place scene: a lower bound is above its upper bound ('min_distance' and "
               "'max_distance', 'min_lift' and 'max_lift')"};
}

}  // namespace

std::optional<Eigen::VectorXd> arm_to(const robot::Robot& robot, Eigen::VectorXd q, const Pose& X_WG) {
  constexpr int kIterations = 200;
  constexpr double kLever = 0.2;  // m that weigh a radian
  const int arm = robot.arm_joints(), body = robot.grasp_frame().body;
  robot::Kinematics kinematics;
  Eigen::Matrix<double, 12, 1> error;
  Eigen::MatrixXd J(12, arm);
  for (int iteration = 0; iteration < kIterations; ++iteration) {
    robot.forward(q, kinematics);
    const Pose X = robot.pose(kinematics, robot.grasp_frame());
    error.head<3>() = X_WG.translation() - X.translation();
    J.topRows(3) = robot.point_jacobian(kinematics, body, X.translation()).leftCols(arm);
    for (int axis = 0; axis < 3; ++axis) {
      error.segment<3>(3 + 3 * axis) = kLever * (X_WG.linear().col(axis) - X.linear().col(axis));
      J.middleRows(3 + 3 * axis, 3) =
          kLever * robot.vector_jacobian(kinematics, body, X.linear().col(axis)).leftCols(arm);
    }
    if (error.head<3>().norm() < 1e-4 && error.tail<9>().norm() < 1e-3 * kLever) return q;
    const Eigen::MatrixXd A = J.transpose() * J + 1e-5 * Eigen::MatrixXd::Identity(arm, arm);
    q.head(arm) += A.ldlt().solve(J.transpose() * error).cwiseMax(-0.3).cwiseMin(0.3);
    q.head(arm) = q.head(arm).cwiseMax(robot.lower().head(arm)).cwiseMin(robot.upper().head(arm));
  }
  return std::nullopt;
}

Result<scene::Scenario> random_place_scenario(const robot::Robot& robot, const PlaceSceneSettings& settings,
                                              std::uint64_t seed, std::uint64_t index) {
  PRIMO_TRY(check(settings));
  PRIMO_ASSIGN(auto table_scene, scene::random_scenario(settings.scenes, seed, index));
  Random random(seed, "random place scene", {index});
  const Eigen::Vector3d shoulder = scene::reach(robot).shoulder_W;
  for (int i = 0; i < kSceneTries; ++i) {
    const double distance = random.uniform(settings.min_distance, settings.max_distance);
    const double angle = random.uniform(-std::numbers::pi, std::numbers::pi);
    const double lift = random.uniform(settings.min_lift, settings.max_lift);
    scene::Object sample;
    Eigen::Vector3d position = table_scene.objects.front().position;
    position += Eigen::Vector3d(distance * std::cos(angle), distance * std::sin(angle), 0);
    position.z() = table_scene.table.top_centre.z() + lift + sample.height / 2;
    sample.position = position;
    if (!scene::centre_over_table(sample, table_scene.table)) continue;
    scene::Scenario scenario = with_held_object(table_scene, settings.scenes.radius, position);
    for (int k = 0; k < kGraspTries; ++k) {
      const Eigen::Vector3d to = position - shoulder;
      const double heading = std::atan2(to.y(), to.x()) + random.uniform(-settings.max_heading, settings.max_heading);
      const double pitch = random.uniform(0, settings.max_pitch);
      const bool flipped = random.uniform() < 0.5;
      if (hold(robot, settings, nominal_grasp(position, heading, pitch, flipped), random, scenario)) return scenario;
    }
  }
  return Error{Code::config, "random place scene " + std::to_string(index) + " of seed " + std::to_string(seed) +
                                 ": the arm finds no start that holds c1 with the margins in " +
                                 std::to_string(kSceneTries) + " draws; ask for smaller margins or fewer obstacles"};
}

}  // namespace primo::physics
