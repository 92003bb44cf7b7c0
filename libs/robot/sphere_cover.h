// Spheres that together hold a shape and hardly more than it: what a distance field is asked with.
#pragma once

#include <vector>

#include "robot/shape.h"

namespace primo::robot {

struct Sphere {
  Eigen::Vector3d centre{0, 0, 0};  ///< m, in the shape's or body's frame, as said where it is used
  double radius = 0;                ///< m
};

/// Every point of the shape is in a sphere, and every point of a sphere is within `tolerance` of the shape; centres in
/// the shape's frame. A capsule of radius r takes spheres of radius r + tolerance along its axis, at most
/// 2 √((r + tolerance)² − r²) apart. Boxes and cylinders are cut into cells, each in its circumscribed sphere: small
/// ones at the surface, larger ones inside. @pre sizes and tolerance are positive.
std::vector<Sphere> sphere_cover(const Shape& shape, double tolerance);

}  // namespace primo::robot
