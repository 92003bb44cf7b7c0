#include "scene/distance_field.h"

#include <gtest/gtest.h>

#include <cmath>

#include "core/random.h"

namespace primo::scene {
namespace {

TEST(DistanceField, distances_and_closest_voxels_are_those_of_an_exhaustive_search) {
  for (std::uint64_t trial = 0; trial < 20; ++trial) {
    Random random(3, "field test", {trial});
    const double voxel = 0.02;
    const Eigen::Vector3i size(5 + static_cast<int>(random.below(14)), 1 + static_cast<int>(random.below(17)),
                               3 + static_cast<int>(random.below(11)));
    const Region region{{-0.3, 0.1, 0.5}, Eigen::Vector3d(-0.3, 0.1, 0.5) + voxel * size.cast<double>()};
    std::vector<Eigen::Vector3d> occupied;
    const auto count = 1 + random.below(40);
    for (std::uint64_t i = 0; i < count; ++i) {
      Eigen::Vector3d p;
      for (int axis = 0; axis < 3; ++axis) p[axis] = random.uniform(region.lower[axis], region.upper[axis]);
      occupied.push_back(p);
    }
    const auto field = DistanceField::build(occupied, region, voxel);
    ASSERT_TRUE(field.ok()) << field.error().message;
    ASSERT_EQ(field->size(), size);
    std::vector<Eigen::Vector3d> centres;
    for (const auto& p : occupied) {
      const Eigen::Vector3d cell = ((p - region.lower) / voxel).array().floor();
      centres.emplace_back(region.lower + (cell + Eigen::Vector3d::Constant(0.5)) * voxel);
    }
    for (int x = 0; x < size.x(); ++x) {
      for (int y = 0; y < size.y(); ++y) {
        for (int z = 0; z < size.z(); ++z) {
          const Eigen::Vector3d p = field->centre({x, y, z});
          double nearest = 1e9;
          for (const auto& centre : centres) nearest = std::min(nearest, (p - centre).norm());
          ASSERT_NEAR(field->distance(p), nearest, 1e-7) << trial;
          const Eigen::Vector3d closest = field->closest(p);
          ASSERT_NEAR((p - closest).norm(), nearest, 1e-7);
          double to_occupied = 1e9;
          for (const auto& centre : centres) to_occupied = std::min(to_occupied, (closest - centre).norm());
          ASSERT_LT(to_occupied, 1e-9) << "the closest voxel is not occupied";
        }
      }
    }
  }
}

TEST(DistanceField, an_empty_field_is_far_from_everything_and_points_outside_are_clamped) {
  const Region region{{0, 0, 0}, {1, 1, 1}};
  const auto empty = DistanceField::build({}, region, 0.1);
  ASSERT_TRUE(empty.ok());
  EXPECT_TRUE(empty->empty());
  EXPECT_EQ(empty->distance({0.5, 0.5, 0.5}), DistanceField::infinite_distance());
  const auto one = DistanceField::build({{0.05, 0.05, 0.05}, {7, 7, 7}}, region, 0.1);
  ASSERT_TRUE(one.ok());
  EXPECT_NEAR(one->distance({-5, 0.05, 0.05}), 0, 1e-12);
  EXPECT_NEAR(one->distance({9, 0.05, 0.05}), 0.9, 1e-6);
}

TEST(DistanceField, absurd_regions_and_resolutions_are_refused) {
  const double nan = std::nan("");
  EXPECT_FALSE(DistanceField::build({}, {{0, 0, 0}, {1, 1, 0}}, 0.1).ok());
  EXPECT_FALSE(DistanceField::build({}, {{0, 0, 0}, {1, 1, 1}}, 0).ok());
  EXPECT_FALSE(DistanceField::build({}, {{0, 0, 0}, {1, 1, 1}}, nan).ok());
  EXPECT_FALSE(DistanceField::build({}, {{0, 0, nan}, {1, 1, 1}}, 0.1).ok());
  EXPECT_FALSE(DistanceField::build({}, {{0, 0, 0}, {1e6, 1e6, 1e6}}, 0.001).ok());
}

}  // namespace
}  // namespace primo::scene
