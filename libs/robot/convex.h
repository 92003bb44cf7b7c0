// Distances between boxes and cylinders by support functions.
#pragma once

#include "robot/distance.h"

namespace primo::robot {

/// As distance(), for any two shapes. Apart: GJK, to 1e-9 m. Overlapping: the smallest overlap over the face normals,
/// the cross products of edges and axes and the line of centres.
Distance convex_distance(const Shape& a, const Pose& X_WA, const Shape& b, const Pose& X_WB);

}  // namespace primo::robot
