// Signed distances between primitive shapes, with their closest points.
//
// Sphere and capsule against sphere and capsule are exact. Sphere and capsule against box and cylinder: the signed
// distance of a convex solid is convex along the capsule's axis, and its minimum there is found by a safeguarded
// one-dimensional search (1e-10 of the axis's length); exact when the axis is outside the solid, and minus the deepest
// axis point's depth minus the radius when it crosses it. Box and cylinder against each other: GJK when apart (Gilbert,
// Johnson, Keerthi, 1988; to 1e-9 m), and the smallest overlap over a set of axes when not: exact for two boxes, at
// least the true depth otherwise.
#pragma once

#include "core/pose.h"
#include "robot/shape.h"

namespace primo::robot {

struct Distance {
  double distance = 0;               ///< m, signed; negative: penetration
  Eigen::Vector3d point_a{0, 0, 0};  ///< on A's surface, in W
  Eigen::Vector3d point_b{0, 0, 0};  ///< on B's surface, in W
  Eigen::Vector3d normal{0, 0, 1};   ///< unit, from B towards A
  /// ∂distance/∂(A's displacement at point_a): the normal, but for an axis inside a solid and equally near to two of
  /// its faces.
  Eigen::Vector3d gradient{0, 0, 1};
};

/// Between shape a at X_WA and shape b at X_WB. Finite for all finite inputs, also when shapes coincide.
Distance distance(const Shape& a, const Pose& X_WA, const Shape& b, const Pose& X_WB);

/// A quick test for pairs that need no distance: false only where a and b are at least `margin` (m) apart.
bool may_be_within(const Shape& a, const Pose& X_WA, const Shape& b, const Pose& X_WB, double margin);

/// Of the point p_B to the surface of `shape`, in the shape's own frame; `normal` is the unit outward direction of
/// increase.
double signed_distance(const Shape& shape, const Eigen::Vector3d& p_B, Eigen::Vector3d& normal);

/// Radius of the smallest sphere about the shape's centre that holds it, m.
double bounding_radius(const Shape& shape);

}  // namespace primo::robot
