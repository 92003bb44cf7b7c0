#include "scene/perception.h"

#include <gtest/gtest.h>
#include <octomap/OcTree.h>

#include <cmath>
#include <limits>

#include "core/random.h"
#include "scene/distance_field.h"
#include "scene/object_estimation.h"
#include "scene/occupancy_map.h"

namespace primo::scene {
namespace {

using Eigen::Vector3d;

/// A cloud of points on the surfaces of a table and an upright cylinder, from the formulas of the surfaces; the camera
/// sits straight above and sees through things, which an estimator of surfaces does not mind.
PointCloud painted_scene(double radius, double height, const Eigen::Vector2d& centre) {
  PointCloud cloud;
  cloud.X_WC = pose(Vector3d(0.8, 0, 1.6), Vector3d(std::numbers::pi, 0, 0));
  const Pose X_CW = cloud.X_WC.inverse();
  const auto paint = [&](const Vector3d& p_W) { cloud.points.push_back((X_CW * p_W).cast<float>()); };
  for (int i = 0; i <= 100; ++i) {
    for (int j = 0; j <= 100; ++j) {
      const Eigen::Vector2d p(0.54 + 0.0052 * i, -0.26 + 0.0052 * j);
      paint({p.x(), p.y(), (p - centre).norm() <= radius ? 0.67 + height : 0.67});
    }
  }
  for (int i = 0; i < 90; ++i) {
    const double a = 2 * std::numbers::pi * i / 90;
    for (int j = 1; j <= 20; ++j) {
      paint({centre.x() + radius * std::cos(a), centre.y() + radius * std::sin(a), 0.67 + height * j / 20});
    }
  }
  return cloud;
}

TEST(Perception, shapes_and_poses_are_those_of_the_painted_surfaces) {
  const auto estimate = perceive({painted_scene(0.04, 0.12, {0.85, -0.07})});
  ASSERT_TRUE(estimate.ok()) << estimate.error().message;
  ASSERT_EQ(estimate->objects.size(), 1U);
  const auto& object = estimate->objects[0];
  EXPECT_EQ(object.name, "o1");
  EXPECT_EQ(object.type, ShapeType::cylinder);
  EXPECT_LT((object.X_WO.translation() - Vector3d(0.85, -0.07, 0.73)).norm(), 5e-4);
  EXPECT_NEAR(object.shape.size.x(), 0.04, 5e-4);
  EXPECT_NEAR(object.shape.size.y(), 0.06, 5e-4);
  EXPECT_NEAR(estimate->table.top_centre.z(), 0.67, 1e-4);
  EXPECT_LT((estimate->table.size - Eigen::Vector2d(0.52, 0.52)).norm(), 0.01);
}

TEST(Perception, labels_only_name_what_is_found_and_never_move_it) {
  PerceptionRequest request;
  request.clouds = {painted_scene(0.04, 0.12, {0.85, -0.07})};
  const auto unnamed = perceive(request);
  request.labels = {{"far", {0.7, 0.2, 0.7}}, {"cup", {0.9, -0.02, 0.7}}};
  const auto named = perceive(request);
  ASSERT_TRUE(unnamed.ok() && named.ok());
  ASSERT_TRUE(named->object("cup"));
  EXPECT_EQ(named->object("cup")->X_WO.matrix(), unnamed->objects[0].X_WO.matrix());
  EXPECT_EQ(named->objects.size(), 1U);
  EXPECT_TRUE(require_objects(*named, {"cup"}).ok());
  const auto status = require_objects(*named, {"cup", "far"});
  ASSERT_FALSE(status.ok());
  EXPECT_NE(status.error().message.find("object far was not found in the points: found cup"), std::string::npos);
}

TEST(Perception, malformed_clouds_are_refused_as_data) {
  const float nan = std::nanf(""), inf = std::numeric_limits<float>::infinity();
  PointCloud good = painted_scene(0.04, 0.12, {0.85, -0.07});
  const auto code = [](const PointCloud& cloud) {
    const auto result = perceive({cloud});
    EXPECT_FALSE(result.ok());
    return result.ok() ? Code::internal : result.error().code;
  };
  EXPECT_EQ(perceive(std::vector<PointCloud>{}).error().code, Code::data);
  EXPECT_EQ(code(PointCloud{}), Code::data);
  for (const float value : {nan, inf, -inf, 1e6F}) {
    PointCloud cloud = good;
    cloud.points[77].y() = value;
    EXPECT_EQ(code(cloud), Code::data);
  }
  PointCloud cloud = good;
  cloud.X_WC.translation().x() = std::nan("");
  EXPECT_EQ(code(cloud), Code::data);
  cloud = good;
  cloud.X_WC.linear() *= 2;
  EXPECT_EQ(code(cloud), Code::data);
  PerceptionSettings settings;
  settings.resolution = 1e-9;
  EXPECT_EQ(perceive({good}, settings).error().code, Code::data);
  settings = {};
  settings.cluster_gap = std::nan("");
  EXPECT_EQ(perceive({good}, settings).error().code, Code::data);
  EXPECT_EQ(perceive(std::vector<PointCloud>(17, good)).error().code, Code::data);
}

TEST(Perception, a_view_without_a_table_says_so) {
  PointCloud cloud;
  for (int i = 0; i < 500; ++i) cloud.points.emplace_back(0.001F * static_cast<float>(i), 0.F, 0.F);
  const auto result = perceive({cloud});
  ASSERT_FALSE(result.ok());
  EXPECT_NE(result.error().message.find("no table was seen"), std::string::npos) << result.error().message;
}

TEST(Perception, a_plane_larger_than_any_table_is_refused) {
  PointCloud cloud;
  for (int i = 0; i < 400; ++i) {
    cloud.points.emplace_back(static_cast<float>(i % 20), static_cast<float>(i / 20), 0.7F);  // 19 × 19 m
  }
  const auto result = perceive({cloud});
  ASSERT_FALSE(result.ok());
  EXPECT_NE(result.error().message.find("must be between 0.05 and 5 m"), std::string::npos) << result.error().message;
}

TEST(Perception, garbage_clouds_end_in_an_error_or_in_finite_estimates) {
  int answers = 0;
  for (std::uint64_t trial = 0; trial < 60; ++trial) {
    Random random(8, "garbage", {trial});
    std::vector<PointCloud> clouds(1 + random.below(3));
    for (auto& cloud : clouds) {
      cloud.X_WC = pose(Vector3d(random.normal(), random.normal(), random.normal()),
                        Vector3d(random.normal(), random.normal(), random.normal()));
      const auto count = random.below(4000);
      const double scale = std::pow(10, random.uniform(-3, 1));
      const auto kind = random.below(4);  // a cloud, a plane, a line, one point again and again
      for (std::uint64_t i = 0; i < count; ++i) {
        Vector3d p(scale * random.normal(), scale * random.normal(), scale * random.normal());
        p = p.cwiseMax(-90).cwiseMin(90);
        if (kind >= 1) p = cloud.X_WC.inverse() * Vector3d(p.x(), kind >= 2 ? 0 : p.y(), 0.7);
        if (kind == 3) p = cloud.X_WC.inverse() * Vector3d(0.8, 0, 0.7);
        p = p.cwiseMax(-90).cwiseMin(90);
        cloud.points.push_back(p.cast<float>());
      }
    }
    const auto estimate = perceive(clouds);
    if (!estimate.ok()) continue;
    ++answers;
    EXPECT_TRUE(estimate->table.top_centre.allFinite() && estimate->table.size.allFinite());
    for (const auto& object : estimate->objects) {
      EXPECT_TRUE(object.X_WO.matrix().allFinite() && object.shape.size.allFinite());
      EXPECT_TRUE(std::isfinite(object.residual));
    }
  }
  EXPECT_GT(answers, 3);
}

TEST(Clusters, groups_are_parted_by_gaps_of_two_voxels_and_joined_below_one) {
  Points points;
  for (int i = 0; i < 100; ++i) {
    points.emplace_back(0.004 * (i % 10), 0.004 * (i / 10), -0.5);
    points.emplace_back(0.036 + 0.017 + 0.004 * (i % 10), 0.004 * (i / 10), -0.5);
  }
  EXPECT_EQ(clusters(points, 0.008, 20).size(), 2U);
  EXPECT_EQ(clusters(points, 0.008, 101).size(), 0U);
  EXPECT_EQ(clusters(points, 0.02, 20).size(), 1U);
  EXPECT_TRUE(clusters({}, 0.008, 1).empty());
}

class Map : public testing::Test {
 protected:
  const PointCloud cloud_ = painted_scene(0.04, 0.12, {0.85, -0.07});
  const Region region_{{0.5, -0.3, 0.6}, {1.1, 0.3, 1.2}};
  const OccupancyMap map_{{cloud_}, region_, 0.02};
};

TEST_F(Map, voxels_of_points_are_occupied_those_before_them_free_and_those_behind_unknown) {
  EXPECT_EQ(map_.at({0.65, 0.1, 0.67}), OccupancyMap::Voxel::occupied);
  EXPECT_EQ(map_.at({0.65, 0.1, 0.9}), OccupancyMap::Voxel::free);
  EXPECT_EQ(map_.at({0.65, 0.1, 0.62}), OccupancyMap::Voxel::unknown);
  EXPECT_EQ(map_.at({0.85, -0.07, 0.79}), OccupancyMap::Voxel::occupied);
  EXPECT_EQ(map_.at({std::nan(""), 0, 0}), OccupancyMap::Voxel::unknown);
  const auto occupied = map_.occupied();
  EXPECT_GT(occupied.size(), 600U);
  for (const auto& centre : occupied) EXPECT_EQ(map_.at(centre), OccupancyMap::Voxel::occupied);
}

TEST_F(Map, its_bytes_read_back_to_the_same_map_here_and_in_octomap) {
  const auto bytes = map_.to_bytes();
  const auto again = OccupancyMap::from_bytes(bytes);
  ASSERT_TRUE(again.ok()) << again.error().message;
  EXPECT_EQ(again->to_bytes(), bytes);
  EXPECT_EQ(again->occupied(), map_.occupied());
  EXPECT_EQ(again->resolution(), 0.02);
  std::istringstream binary(std::string(bytes.begin(), bytes.end()));
  octomap::OcTree tree(0.1);
  testing::internal::CaptureStderr();
  ASSERT_TRUE(tree.readBinary(binary));
  testing::internal::GetCapturedStderr();
  EXPECT_EQ(tree.getResolution(), 0.02);
  EXPECT_EQ(tree.size(), map_.tree().size());
}

TEST_F(Map, broken_streams_are_refused) {
  const auto bytes = map_.to_bytes();
  EXPECT_FALSE(OccupancyMap::from_bytes({}).ok());
  auto cut = bytes;
  cut.resize(bytes.size() - 5);
  EXPECT_FALSE(OccupancyMap::from_bytes(cut).ok());
  auto longer = bytes;
  longer.push_back(0);
  EXPECT_FALSE(OccupancyMap::from_bytes(longer).ok());
  for (std::uint64_t trial = 0; trial < 500; ++trial) {  // must not crash or hang, whatever the answer
    Random random(4, "octree", {trial});
    auto broken = bytes;
    const auto changes = 1 + random.below(20);
    for (std::uint64_t i = 0; i < changes; ++i) {
      broken[random.below(broken.size())] = static_cast<std::uint8_t>(random.below(256));
    }
    broken.resize(1 + random.below(broken.size()));
    const auto map = OccupancyMap::from_bytes(broken);
    if (!map.ok()) {
      EXPECT_EQ(map.error().code, Code::data);
    }
  }
}

TEST_F(Map, the_field_of_an_estimate_is_zero_on_surfaces_and_grows_off_them) {
  const auto estimate = perceive({cloud_});
  ASSERT_TRUE(estimate.ok());
  const auto field = distance_field(*estimate);
  ASSERT_TRUE(field.ok()) << field.error().message;
  EXPECT_EQ(field->distance({0.65, 0.1, 0.67}), 0);
  EXPECT_NEAR(field->distance({0.65, 0.1, 0.87}), 0.2, 0.021);
  EXPECT_NEAR(field->distance({0.85, -0.07, 0.99}), 0.2, 0.021);
}

}  // namespace
}  // namespace primo::scene
