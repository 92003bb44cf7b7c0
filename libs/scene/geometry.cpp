#include "scene/geometry.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

namespace primo::scene {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

/// The outline of an upright object seen from above: a disc, or a rectangle with its axes u and its perpendicular.
struct Footprint {
  bool disc = true;
  Vector2d centre{0, 0};
  double radius = 0;
  Vector2d u{1, 0};
  Vector2d half{0, 0};

  Vector2d v() const { return {-u.y(), u.x()}; }
  std::array<Vector2d, 4> corners() const {
    return {centre + half.x() * u + half.y() * v(), centre - half.x() * u + half.y() * v(),
            centre - half.x() * u - half.y() * v(), centre + half.x() * u - half.y() * v()};
  }
};

Footprint footprint(const Object& object) {
  Footprint f;
  const Pose X_WO = object.X_WO();
  f.centre = X_WO.translation().head<2>();
  f.disc = object.type == ShapeType::cylinder;
  if (f.disc) {
    f.radius = object.radius;
  } else {
    f.u = X_WO.linear().col(0).head<2>().normalized();
    f.half = object.half_extents.head<2>();
  }
  return f;
}

double point_to_rectangle(const Vector2d& p, const Footprint& rectangle) {
  const Vector2d r = p - rectangle.centre;
  const Vector2d d = Vector2d(std::abs(r.dot(rectangle.u)), std::abs(r.dot(rectangle.v()))) - rectangle.half;
  return d.maxCoeff() <= 0 ? d.maxCoeff() : d.cwiseMax(0).norm();
}

/// Two rectangles: separated along one of four axes, then the distance is from a corner of one to the other.
double rectangles(const Footprint& a, const Footprint& b) {
  double separation = -1e9;
  for (const Vector2d& axis : {a.u, a.v(), b.u, b.v()}) {
    const auto extent = [&axis](const Footprint& f) {
      return f.half.x() * std::abs(f.u.dot(axis)) + f.half.y() * std::abs(f.v().dot(axis));
    };
    separation = std::max(separation, std::abs((b.centre - a.centre).dot(axis)) - extent(a) - extent(b));
  }
  if (separation <= 0) return separation;
  double distance = 1e9;
  for (const Vector2d& corner : a.corners()) distance = std::min(distance, point_to_rectangle(corner, b));
  for (const Vector2d& corner : b.corners()) distance = std::min(distance, point_to_rectangle(corner, a));
  return distance;
}

double planar_gap(const Footprint& a, const Footprint& b) {
  if (a.disc && b.disc) return (a.centre - b.centre).norm() - a.radius - b.radius;
  if (a.disc) return point_to_rectangle(a.centre, b) - a.radius;
  if (b.disc) return point_to_rectangle(b.centre, a) - b.radius;
  return rectangles(a, b);
}

double half_height(const Object& object) {
  return object.type == ShapeType::cylinder ? object.height / 2 : object.half_extents.z();
}

/// Directions that may separate two tilted objects: their axes, the line of centres, crosses of axes and a coarse
/// sphere.
std::vector<Vector3d> candidate_axes(const Pose& X_WA, const Pose& X_WB) {
  std::vector<Vector3d> axes;
  for (int i = 0; i < 3; ++i) {
    axes.push_back(X_WA.linear().col(i));
    axes.push_back(X_WB.linear().col(i));
    for (int j = 0; j < 3; ++j) axes.push_back(X_WA.linear().col(i).cross(X_WB.linear().col(j)));
  }
  const Vector3d line = X_WB.translation() - X_WA.translation();
  axes.push_back(line);
  for (int i = 0; i < 3; ++i) {
    const Vector3d axis = X_WA.linear().col(i);
    axes.push_back(line - line.dot(axis) * axis);
    const Vector3d other = X_WB.linear().col(i);
    axes.push_back(line - line.dot(other) * other);
  }
  for (int x = -2; x <= 2; ++x) {
    for (int y = -2; y <= 2; ++y) {
      for (int z = 0; z <= 2; ++z) axes.emplace_back(x, y, z);
    }
  }
  return axes;
}

}  // namespace

double support(const Shape& shape, const Pose& X_WS, const Vector3d& direction_W) {
  const Vector3d d = X_WS.linear().transpose() * direction_W;
  const double centre = direction_W.dot(X_WS.translation());
  switch (shape.type) {
    case ShapeType::sphere:
      return centre + shape.size.x() * d.norm();
    case ShapeType::capsule:
      return centre + shape.size.x() * d.norm() + shape.size.y() * std::abs(d.z());
    case ShapeType::cylinder:
      return centre + shape.size.x() * d.head<2>().norm() + shape.size.y() * std::abs(d.z());
    case ShapeType::box:
      return centre + shape.size.dot(d.cwiseAbs());
  }
  return centre;
}

bool upright(const Object& object) { return object.X_WO().linear().col(2).head<2>().norm() < 1e-6; }

double gap(const Object& a, const Object& b) {
  if (upright(a) && upright(b)) {
    const double planar = planar_gap(footprint(a), footprint(b));
    const double vertical = std::abs(a.position.z() - b.position.z()) - half_height(a) - half_height(b);
    return planar > 0 && vertical > 0 ? std::hypot(planar, vertical) : std::max(planar, vertical);
  }
  const Pose X_WA = a.X_WO(), X_WB = b.X_WO();
  double best = -1e9;
  for (const Vector3d& axis : candidate_axes(X_WA, X_WB)) {
    if (axis.norm() < 1e-9) continue;
    const Vector3d n = axis.normalized();
    for (const double sign : {-1.0, 1.0}) {
      const Vector3d direction = sign * n;
      best = std::max(best, -support(a.shape(), X_WA, direction) - support(b.shape(), X_WB, -direction));
    }
  }
  return best;
}

double height_over_table(const Object& object, const Table& table) {
  return -support(object.shape(), object.X_WO(), -Vector3d::UnitZ()) - table.top_centre.z();
}

bool centre_over_table(const Object& object, const Table& table) {
  const Vector2d offset = (object.position - table.top_centre).head<2>().cwiseAbs();
  return (offset.array() <= table.size.array() / 2).all();
}

}  // namespace primo::scene
