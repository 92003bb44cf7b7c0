#include "scene/distance_field.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

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

TEST(DistanceField, interpolation_is_exact_at_voxel_centres_and_within_a_diagonal_between_them) {
  Random random(5, "field test");
  std::vector<Eigen::Vector3d> occupied;
  for (int i = 0; i < 12; ++i) {
    Eigen::Vector3d voxel;
    for (int axis = 0; axis < 3; ++axis) voxel[axis] = static_cast<double>(random.below(20));
    occupied.emplace_back((voxel.array() + 0.5) * 0.02);
  }
  const auto field = distance_field(occupied, 0.02, 0.1).value();
  Eigen::Vector3d gradient;
  for (int x = 0; x < field.size().x(); x += 3) {
    for (int y = 0; y < field.size().y(); y += 2) {
      for (int z = 0; z < field.size().z(); z += 5) {
        const Eigen::Vector3d p = field.centre({x, y, z});
        ASSERT_NEAR(field.interpolate(p, gradient), field.distance(p), 1e-6);
      }
    }
  }
  for (int i = 0; i < 5000; ++i) {
    Eigen::Vector3d p;
    for (int axis = 0; axis < 3; ++axis) p[axis] = random.uniform(-0.4, 0.8);
    double nearest = 1e9;
    for (const auto& centre : occupied) nearest = std::min(nearest, (p - centre).norm());
    // Outside the grid it is a lower bound, inside within a voxel's diagonal.
    const double d = field.interpolate(p, gradient);
    ASSERT_LE(d, nearest + std::sqrt(3.0) * 0.02);
    const bool inside = (p.array() > -0.05).all() && (p.array() < 0.35).all();
    if (inside) ASSERT_GE(d, nearest - std::sqrt(3.0) * 0.02);
  }
}

TEST(DistanceField, gradients_of_the_interpolation_agree_with_central_differences_in_and_outside_the_grid) {
  const auto field =
      distance_field(std::vector<Eigen::Vector3d>{{0.1, 0.2, 0.3}, {0.25, 0.2, 0.35}, {0.2, 0.05, 0.1}}, 0.02, 0.06)
          .value();
  Random random(6, "field test");
  int kinks = 0;
  for (int i = 0; i < 3000; ++i) {
    Eigen::Vector3d p, gradient, ignored;
    for (int axis = 0; axis < 3; ++axis) p[axis] = random.uniform(-0.2, 0.6);
    const double d = field.interpolate(p, gradient);
    for (int axis = 0; axis < 3; ++axis) {
      const Eigen::Vector3d step = 1e-7 * Eigen::Vector3d::Unit(axis);
      const double ahead = field.interpolate(p + step, ignored), behind = field.interpolate(p - step, ignored);
      if (std::abs(ahead - 2 * d + behind) > 1e-10) {
        ++kinks;  // a face between two cells
        continue;
      }
      ASSERT_NEAR(gradient[axis], (ahead - behind) / 2e-7, 1e-5);
    }
  }
  EXPECT_LT(kinks, 90);
}

TEST(DistanceField, interpolation_of_an_empty_field_is_far_and_flat) {
  const auto field = distance_field(std::vector<Eigen::Vector3d>{}, 0.01, 0.1).value();
  Eigen::Vector3d gradient(1, 1, 1);
  EXPECT_EQ(field.interpolate({3, 4, 5}, gradient), DistanceField::infinite_distance());
  EXPECT_EQ(gradient.norm(), 0);
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
