// Signed distances between primitive shapes, with their closest points.
//
// Exact (to rounding): sphere and capsule against sphere, capsule and box; sphere against cylinder. Capsule against
// cylinder: the distance of the capsule's axis to a convex solid is a convex function of one parameter, minimised by a
// safeguarded search to about 1e-9 m. Box and cylinder against box and cylinder: separating axes give a lower bound
// that is exact for faces and edges of boxes; see distance() below. Penetration is negative. A capsule whose axis
// crosses a solid gets minus the depth of the deepest axis point (plus the radius), which is a lower bound of the
// penetration depth's magnitude.
#pragma once

#include "core/pose.h"
#include "robot/shape.h"

namespace primo::robot {

struct Distance {
  double distance = 0;               ///< m, signed
  Eigen::Vector3d point_a{0, 0, 0};  ///< on A's surface, in W
  Eigen::Vector3d point_b{0, 0, 0};  ///< on B's surface, in W
  Eigen::Vector3d normal{0, 0, 1};   ///< unit, from B towards A: ∂distance/∂(A's displacement)
};

/// Between shape a at X_WA and shape b at X_WB. Finite for all finite inputs, also when shapes coincide.
Distance distance(const Shape& a, const Pose& X_WA, const Shape& b, const Pose& X_WB);

/// Radius of the smallest sphere about the shape's centre that holds it, m.
double bounding_radius(const Shape& shape);

}  // namespace primo::robot
