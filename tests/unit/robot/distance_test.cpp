#include "robot/distance.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "core/random.h"

namespace primo::robot {
namespace {

Pose random_pose(Random& random, double extent) {
  const Eigen::Vector3d p(random.uniform(-extent, extent), random.uniform(-extent, extent),
                          random.uniform(-extent, extent));
  return pose(p, Eigen::Quaterniond(random.normal(), random.normal(), random.normal(), random.normal()));
}

Shape random_shape(ShapeType type, Random& random) {
  return {type, {random.uniform(0.02, 0.2), random.uniform(0.02, 0.3), random.uniform(0.02, 0.3)}};
}

/// Whether a point is inside, by the shape's definition alone.
bool contains(const Shape& s, const Eigen::Vector3d& p, double slack) {
  switch (s.type) {
    case ShapeType::sphere:
      return p.norm() <= s.size[0] + slack;
    case ShapeType::capsule: {
      const double z = std::max(0.0, std::abs(p.z()) - s.size[1]);
      return std::sqrt(p.x() * p.x() + p.y() * p.y() + z * z) <= s.size[0] + slack;
    }
    case ShapeType::cylinder:
      return std::hypot(p.x(), p.y()) <= s.size[0] + slack && std::abs(p.z()) <= s.size[1] + slack;
    case ShapeType::box:
      return ((p.cwiseAbs() - s.size).array() <= slack).all();
  }
  return false;
}

/// The nearest point of the shape to p (both in the shape's frame), by its definition.
Eigen::Vector3d project(const Shape& s, const Eigen::Vector3d& p) {
  if (contains(s, p, 0)) return p;
  switch (s.type) {
    case ShapeType::sphere:
      return s.size[0] / p.norm() * p;
    case ShapeType::capsule: {
      const Eigen::Vector3d axis(0, 0, std::clamp(p.z(), -s.size[1], s.size[1]));
      return axis + s.size[0] / (p - axis).norm() * (p - axis);
    }
    case ShapeType::cylinder: {
      const double rho = std::hypot(p.x(), p.y()), scale = rho > s.size[0] ? s.size[0] / rho : 1;
      return {scale * p.x(), scale * p.y(), std::clamp(p.z(), -s.size[1], s.size[1])};
    }
    case ShapeType::box:
      return p.cwiseMin(s.size).cwiseMax(-s.size);
  }
  return p;
}

/// Distance of two convex bodies by alternating projections: slow and independent; an upper bound that converges from
/// above.
double by_projections(const Shape& a, const Pose& X_WA, const Shape& b, const Pose& X_WB, int iterations = 20000) {
  Eigen::Vector3d p = X_WA.translation(), q = p;
  for (int i = 0; i < iterations; ++i) {
    q = X_WB * project(b, X_WB.inverse() * p);
    const Eigen::Vector3d next = X_WA * project(a, X_WA.inverse() * q);
    if ((next - p).norm() < 1e-13) break;
    p = next;
  }
  return (p - q).norm();
}

const std::vector<ShapeType> kTypes = {ShapeType::sphere, ShapeType::capsule, ShapeType::cylinder, ShapeType::box};

TEST(Distance, OfSeparatedShapesAgreesWithAlternatingProjections) {
  for (const auto type_a : kTypes) {
    for (const auto type_b : kTypes) {
      int separated = 0;
      for (std::uint64_t i = 0; separated < 30; ++i) {
        Random random(3, "distance_test", {static_cast<std::uint64_t>(type_a), static_cast<std::uint64_t>(type_b), i});
        const Shape a = random_shape(type_a, random), b = random_shape(type_b, random);
        const Pose X_WA = random_pose(random, 0.6), X_WB = random_pose(random, 0.6);
        const double expected = by_projections(a, X_WA, b, X_WB);
        if (expected < 0.01) continue;
        ++separated;
        const Distance d = distance(a, X_WA, b, X_WB);
        // The reference converges slowly where faces are nearly parallel, always from above.
        ASSERT_NEAR(d.distance, expected, 2e-5) << i << " types " << int(type_a) << " " << int(type_b);
        ASSERT_LE(d.distance, expected + 1e-8);
        ASSERT_NEAR((d.point_a - d.point_b).norm(), d.distance, 1e-7);
        ASSERT_TRUE(contains(a, X_WA.inverse() * d.point_a, 1e-7));
        ASSERT_TRUE(contains(b, X_WB.inverse() * d.point_b, 1e-7));
        ASSERT_NEAR((d.point_a - d.point_b).dot(d.normal), d.distance, 1e-7);
      }
    }
  }
}

TEST(Distance, IsTheSameEitherWayRound) {
  for (const auto type_a : kTypes) {
    for (const auto type_b : kTypes) {
      for (std::uint64_t i = 0; i < 50; ++i) {
        Random random(4, "distance_test", {static_cast<std::uint64_t>(type_a), static_cast<std::uint64_t>(type_b), i});
        const Shape a = random_shape(type_a, random), b = random_shape(type_b, random);
        const Pose X_WA = random_pose(random, 0.3), X_WB = random_pose(random, 0.3);
        ASSERT_NEAR(distance(a, X_WA, b, X_WB).distance, distance(b, X_WB, a, X_WA).distance, 1e-8);
      }
    }
  }
}

TEST(Distance, NormalIsItsGradientUnderDisplacement) {
  for (const auto type_a : {ShapeType::sphere, ShapeType::capsule}) {
    for (const auto type_b : kTypes) {
      for (std::uint64_t i = 0; i < 30; ++i) {
        Random random(5, "distance_test", {static_cast<std::uint64_t>(type_a), static_cast<std::uint64_t>(type_b), i});
        const Shape a = random_shape(type_a, random), b = random_shape(type_b, random);
        const Pose X_WA = random_pose(random, 0.4), X_WB = random_pose(random, 0.4);
        const Distance d = distance(a, X_WA, b, X_WB);
        if (d.distance < 0.005) continue;
        for (int k = 0; k < 3; ++k) {
          Pose ahead = X_WA, behind = X_WA;
          ahead.translation()[k] += 1e-6;
          behind.translation()[k] -= 1e-6;
          const double slope = (distance(a, ahead, b, X_WB).distance - distance(a, behind, b, X_WB).distance) / 2e-6;
          ASSERT_NEAR(slope, d.normal[k], 1e-3) << int(type_a) << " " << int(type_b) << " " << i;
        }
      }
    }
  }
}

TEST(Distance, OfACapsuleInABoxIsItsAxisDepthAndRadius) {
  const Shape capsule{ShapeType::capsule, {0.02, 0.1, 0}}, box{ShapeType::box, {0.5, 0.5, 0.05}};
  // The axis lies flat, 1 cm below the top.
  const Pose lying = pose(Eigen::Vector3d(0.1, 0, 0.04), Eigen::Vector3d(0, M_PI / 2, 0));
  const Distance d = distance(capsule, lying, box, Pose::Identity());
  EXPECT_NEAR(d.distance, -0.03, 1e-9);
  EXPECT_NEAR(d.normal.z(), 1, 1e-9);
  EXPECT_NEAR(d.point_b.z(), 0.05, 1e-9);
}

TEST(Distance, OfOverlappingBoxesIsTheSmallestOverlap) {
  const Shape a{ShapeType::box, {0.1, 0.1, 0.1}}, b{ShapeType::box, {0.2, 0.3, 0.4}};
  const Distance d = distance(a, pose(Eigen::Vector3d(0.27, 0.05, 0)), b, Pose::Identity());
  EXPECT_NEAR(d.distance, -0.03, 1e-12);
  EXPECT_NEAR(d.normal.x(), 1, 1e-12);
}

TEST(Distance, OfOverlappingSolidsIsNegativeAndMovingByItSeparatesThem) {
  for (const auto type_a : {ShapeType::cylinder, ShapeType::box}) {
    for (std::uint64_t i = 0; i < 100; ++i) {
      Random random(6, "distance_test", {static_cast<std::uint64_t>(type_a), i});
      const Shape a = random_shape(type_a, random), b = random_shape(ShapeType::cylinder, random);
      Pose X_WA = random_pose(random, 0.05);
      const Pose X_WB = random_pose(random, 0.05);
      const Distance d = distance(a, X_WA, b, X_WB);
      if (d.distance >= 0) continue;
      X_WA.translation() -= (d.distance - 1e-6) * d.normal;
      ASSERT_GE(distance(a, X_WA, b, X_WB).distance, 0) << i;
    }
  }
}

TEST(Distance, IsFiniteForCoincidentAndDegenerateShapes) {
  for (const auto type_a : kTypes) {
    for (const auto type_b : kTypes) {
      for (const double size : {0.1, 1e-9, 0.0}) {
        const Shape a{type_a, {size, size, size}}, b{type_b, {0.1, 0.1, 0.1}};
        const Distance d = distance(a, Pose::Identity(), b, Pose::Identity());
        EXPECT_TRUE(std::isfinite(d.distance));
        EXPECT_TRUE(d.point_a.allFinite() && d.point_b.allFinite());
        EXPECT_NEAR(d.normal.norm(), 1, 1e-9);
      }
    }
  }
}

TEST(SignedDistance, IsTheNearestSurfacePointsDistance) {
  for (const auto type : kTypes) {
    Random random(8, "signed_distance_test", {static_cast<std::uint64_t>(type)});
    const Shape shape = random_shape(type, random);
    for (int i = 0; i < 500; ++i) {
      const Eigen::Vector3d p(random.uniform(-0.5, 0.5), random.uniform(-0.5, 0.5), random.uniform(-0.5, 0.5));
      Eigen::Vector3d normal;
      const double d = signed_distance(shape, p, normal);
      EXPECT_EQ(d <= 0, contains(shape, p, 0));
      if (d > 0) {
        EXPECT_NEAR(d, (p - project(shape, p)).norm(), 1e-12);
      } else {
        // Along the normal the surface is |d| away, and no nearer along any other direction tried.
        EXPECT_TRUE(contains(shape, p - (d + 1e-9) * normal, 0));
        EXPECT_FALSE(contains(shape, p - (d - 1e-9) * normal, 0));
        const Eigen::Vector3d other = Eigen::Vector3d(random.normal(), random.normal(), random.normal()).normalized();
        EXPECT_TRUE(contains(shape, p - d * other, 1e-12));
      }
    }
  }
}

TEST(Distance, TheQuickTestNeverMissesAPairWithinTheMargin) {
  Random random(3, "quick");
  int quick = 0, far = 0;
  for (int i = 0; i < 20000; ++i) {
    const Shape a = random_shape(static_cast<ShapeType>(i % 4), random);
    const Shape b = random_shape(static_cast<ShapeType>(i / 4 % 4), random);
    const Pose X_WA = random_pose(random, 0.6), X_WB = random_pose(random, 0.6);
    const double margin = random.uniform(0.001, 0.1);
    const bool maybe = may_be_within(a, X_WA, b, X_WB, margin);
    const bool within = distance(a, X_WA, b, X_WB).distance < margin;
    EXPECT_TRUE(maybe || !within);
    far += !within;
    quick += !maybe;
  }
  EXPECT_GT(quick, far / 4) << "of " << far;
}

TEST(Distance, CapsulesAtACylindersSideAreAsFarAsTheAxesSay) {
  // Parallel axes, and an axis across: distances in the plane, by hand.
  const Shape finger{ShapeType::capsule, {0.01, 0.03, 0}}, object{ShapeType::cylinder, {0.04, 0.05, 0}};
  const auto side = distance(finger, pose(Eigen::Vector3d(0.07, 0, 0.01)), object, Pose::Identity());
  EXPECT_NEAR(side.distance, 0.02, 1e-12);
  EXPECT_LT((side.normal - Eigen::Vector3d::UnitX()).norm(), 1e-9);
  const Pose across = pose(Eigen::Vector3d(0, 0.08, -0.02), Eigen::Vector3d(0, M_PI / 2, 0));
  const auto crossing = distance(finger, across, object, Pose::Identity());
  EXPECT_NEAR(crossing.distance, 0.03, 1e-12);
  EXPECT_LT((crossing.gradient - Eigen::Vector3d::UnitY()).norm(), 1e-9);
}

}  // namespace
}  // namespace primo::robot
