#include "robot/mesh_cover.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "core/random.h"
#include "robot/distance.h"
#include "robot/mjcf.h"
#include "robot_text.h"

namespace primo::robot {
namespace {

Eigen::Matrix3Xf cloud(std::uint64_t seed, const Eigen::Vector3d& size, bool round) {
  Random random(seed, "cloud");
  Eigen::Matrix3Xf points(3, 200);
  for (int i = 0; i < points.cols(); ++i) {
    Eigen::Vector3d p(random.uniform(-1, 1), random.uniform(-1, 1), random.uniform(-1, 1));
    if (round) p.normalize();
    points.col(i) = (p.cwiseProduct(size) + Eigen::Vector3d(0.3, -0.2, 0.1)).cast<float>();
  }
  return points;
}

double deepest_outside(const Cover& cover, const Eigen::Matrix3Xf& points) {
  double outside = -1;
  Eigen::Vector3d normal;
  for (int i = 0; i < points.cols(); ++i) {
    const Eigen::Vector3d p = points.col(i).cast<double>();
    outside = std::max(outside, signed_distance(cover.shape, cover.X_MS.inverse() * p, normal));
  }
  return outside;
}

TEST(MeshCover, HoldsEveryPointWhateverTheForm) {
  for (std::uint64_t seed = 0; seed < 50; ++seed) {
    Random random(seed, "size");
    const Eigen::Vector3d size(random.uniform(0.001, 0.2), random.uniform(0.001, 0.2), random.uniform(0.001, 0.2));
    const auto points = cloud(seed, size, seed % 2 == 0);
    EXPECT_LT(deepest_outside(cover(points), points), 1e-9);
  }
}

TEST(MeshCover, IsABallABoxOrACapsuleWhereTheMeshIs) {
  EXPECT_EQ(cover(cloud(1, {0.1, 0.1, 0.1}, true)).shape.type, ShapeType::sphere);
  Eigen::Matrix3Xf corners(3, 8);
  for (int i = 0; i < 8; ++i) corners.col(i) << (i & 1 ? 0.1F : -0.1F), (i & 2 ? 0.2F : -0.2F), (i & 4 ? 0.3F : -0.3F);
  const Cover box = cover(corners);
  EXPECT_EQ(box.shape.type, ShapeType::box);
  EXPECT_LT((box.shape.size - Eigen::Vector3d(0.1, 0.2, 0.3)).norm(), 1e-6);
  // A tube along y with round ends: radius 0.05, 0.4 m between the ends' centres.
  Eigen::Matrix3Xf tube(3, 4000);
  Random random(2, "tube");
  for (int i = 0; i < tube.cols(); ++i) {
    Eigen::Vector3d p = 0.05 * Eigen::Vector3d(random.normal(), random.normal(), random.normal()).normalized();
    p.y() += i % 2 ? 0.2 : -0.2;
    tube.col(i) = p.cast<float>();
  }
  const Cover capsule = cover(tube);
  ASSERT_EQ(capsule.shape.type, ShapeType::capsule);
  EXPECT_NEAR(capsule.shape.size[0], 0.05, 1e-3);
  EXPECT_NEAR(capsule.shape.size[1], 0.2, 5e-3);
  EXPECT_NEAR(std::abs(capsule.X_MS.linear().col(2).y()), 1, 1e-9);
}

TEST(MeshCover, ReplacesMeshesThatCollideAndLeavesMassesAndMeshesToBeSeen) {
  const std::string text = R"(<mujoco><asset><mesh name="m" vertex="0 0 0  .2 0 0  0 .1 0  0 0 .1"/></asset><worldbody>
    <body pos="0 0 1" euler="30 40 50"><joint/><geom name="felt" type="mesh" mesh="m" mass="1" pos=".1 .2 .3" euler="10 20 30"/>
    <geom name="seen" type="mesh" mesh="m" contype="0" conaffinity="0" mass="0"/></body></worldbody></mujoco>)";
  auto before = compile_mjcf(text, {}, "test"), after = compile_mjcf(text, {}, "test");
  ASSERT_TRUE(before.ok()) << before.error().message;
  ASSERT_TRUE(cover_meshes(**after, "test").ok());
  const mjModel &b = **before, &a = **after;
  const int felt = mj_name2id(&a, mjOBJ_GEOM, "felt"), seen = mj_name2id(&a, mjOBJ_GEOM, "seen");
  EXPECT_NE(a.geom_type[felt], mjGEOM_MESH);
  EXPECT_EQ(a.geom_type[seen], mjGEOM_MESH);
  EXPECT_EQ(a.body_mass[1], b.body_mass[1]);
  // Where the mesh's points are in the world, the cover is.
  const auto data = [](const mjModel& m) {
    std::unique_ptr<mjData, decltype(&mj_deleteData)> made(mj_makeData(&m), &mj_deleteData);
    mj_kinematics(&m, made.get());
    return made;
  };
  const auto in_before = data(b), in_after = data(a);
  const auto at = [](const mjData& d, int g) {
    Pose X = Pose::Identity();
    X.linear() = Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(d.geom_xmat + 9 * g);
    X.translation() = Eigen::Map<const Eigen::Vector3d>(d.geom_xpos + 3 * g);
    return X;
  };
  const Pose X_WM = at(*in_before, felt), X_WS = at(*in_after, felt);
  const Shape shape{a.geom_type[felt] == mjGEOM_BOX       ? ShapeType::box
                    : a.geom_type[felt] == mjGEOM_CAPSULE ? ShapeType::capsule
                                                          : ShapeType::sphere,
                    Eigen::Map<const Eigen::Vector3d>(a.geom_size + 3 * felt)};
  Eigen::Vector3d normal;
  const int mesh = b.geom_dataid[felt];
  for (int v = 0; v < b.mesh_vertnum[mesh]; ++v) {
    const Eigen::Vector3d p =
        Eigen::Map<const Eigen::Vector3f>(b.mesh_vert + 3 * (b.mesh_vertadr[mesh] + v)).cast<double>();
    EXPECT_LT(signed_distance(shape, X_WS.inverse() * (X_WM * p), normal), 1e-7);
  }
}

TEST(MeshCover, ARobotWithCollidingMeshesIsPlannedWithTheirCovers) {
  const RobotFolder folder;
  write_robot(folder, {.fingers = 2});
  std::string text = read_file(folder.path("robot.xml")).value();
  const std::string palm = "<geom type=\"box\" size=\"0.05 0.05 0.01\" mass=\"0.3\"/>";
  text.replace(text.find(palm), palm.size(), "<geom name=\"palm\" type=\"mesh\" mesh=\"block\" mass=\"0.3\"/>");
  text.replace(
      text.find("<worldbody>"), 0,
      "<asset><mesh name=\"block\" vertex=\"-.05 -.04 -.01 .05 -.04 -.01 -.05 .04 -.01 .05 .04 -.01 -.05 -.04 .01 "
      ".05 -.04 .01 -.05 .04 .01 .05 .04 .01\"/></asset>");
  folder.put("robot.xml", text);
  auto robot = folder.load();
  ASSERT_TRUE(robot.ok()) << robot.error().message;
  const auto& links = robot->link_shapes();
  const auto found = std::find_if(links.begin(), links.end(), [](const auto& link) { return link.name == "palm"; });
  ASSERT_NE(found, links.end());
  EXPECT_EQ(found->shape.type, ShapeType::box);
  Eigen::Vector3d size = found->shape.size;
  std::sort(size.begin(), size.end());
  EXPECT_LT((size - Eigen::Vector3d(0.01, 0.04, 0.05)).norm(), 1e-6);
}

}  // namespace
}  // namespace primo::robot
