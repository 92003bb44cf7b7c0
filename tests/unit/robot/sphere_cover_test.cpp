#include "robot/sphere_cover.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "core/random.h"
#include "robot/distance.h"

namespace primo::robot {
namespace {

Shape draw(Random& random) {
  const auto length = [&] { return std::pow(10.0, random.uniform(-2.5, -0.6)); };  // 3 mm … 0.25 m
  return {static_cast<ShapeType>(random.below(4)), {length(), length(), length()}};
}

/// A uniform direction.
Eigen::Vector3d direction(Random& random) {
  Eigen::Vector3d v;
  for (int i = 0; i < 3; ++i) v[i] = random.normal();
  return v.normalized();
}

TEST(SphereCover, HoldsEveryPointOfTheShape) {
  for (std::uint64_t i = 0; i < 200; ++i) {
    Random random(1, "sphere cover", {i});
    const Shape shape = draw(random);
    const auto spheres = sphere_cover(shape, 0.01);
    const double reach = bounding_radius(shape);
    int inside = 0;
    for (int k = 0; k < 20000 && inside < 1000; ++k) {
      Eigen::Vector3d p;
      for (int axis = 0; axis < 3; ++axis) p[axis] = random.uniform(-reach, reach);
      Eigen::Vector3d normal;
      const double d = signed_distance(shape, p, normal);
      if (d > 0.02) continue;
      p -= std::max(0.0, d + 1e-9) * normal;  // points near the surface are moved onto it
      ++inside;
      const bool held = std::any_of(spheres.begin(), spheres.end(), [&](const Sphere& sphere) {
        return (p - sphere.centre).norm() <= sphere.radius + 1e-7;
      });
      ASSERT_TRUE(held) << "shape " << i << " point " << p.transpose();
    }
    ASSERT_GT(inside, 20) << i;
  }
}

TEST(SphereCover, StaysWithinTheToleranceOfTheShape) {
  for (std::uint64_t i = 0; i < 200; ++i) {
    Random random(2, "sphere cover", {i});
    const Shape shape = draw(random);
    for (const Sphere& sphere : sphere_cover(shape, 0.01)) {
      for (int k = 0; k < 50; ++k) {
        Eigen::Vector3d normal;
        const Eigen::Vector3d p = sphere.centre + sphere.radius * direction(random);
        ASSERT_LE(signed_distance(shape, p, normal), 0.01 + 1e-9) << "shape " << i;
      }
    }
  }
}

TEST(SphereCover, OfASphereIsItselfAndOfACapsuleAFewAlongItsAxis) {
  const auto ball = sphere_cover({ShapeType::sphere, {0.03, 0, 0}}, 0.01);
  ASSERT_EQ(ball.size(), 1u);
  EXPECT_EQ(ball[0].radius, 0.03);
  // Spheres of radius 0.07 hold a cylinder of radius 0.06 over 2 √(0.07² − 0.06²) = 0.0721 m each: 0.175 m take 3 gaps.
  EXPECT_EQ(sphere_cover({ShapeType::capsule, {0.06, 0.0875, 0}}, 0.01).size(), 4u);
}

}  // namespace
}  // namespace primo::robot
