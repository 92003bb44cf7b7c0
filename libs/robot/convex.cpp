#include "robot/convex.h"

#include <Eigen/LU>
#include <array>
#include <cmath>
#include <limits>

namespace primo::robot {
namespace {

using Eigen::Vector3d;

/// The point of the shape that is furthest along n, in the shape's frame.
Vector3d local_support(const Shape& shape, const Vector3d& n) {
  const auto sign = [](double x) { return x < 0 ? -1.0 : 1.0; };
  switch (shape.type) {
    case ShapeType::box:
      return {sign(n.x()) * shape.size.x(), sign(n.y()) * shape.size.y(), sign(n.z()) * shape.size.z()};
    case ShapeType::cylinder: {
      const double rho = std::hypot(n.x(), n.y());
      const double scale = rho > 1e-12 ? shape.size[0] / rho : 0.0;
      return {scale * n.x(), scale * n.y(), sign(n.z()) * shape.size[1]};
    }
    case ShapeType::capsule:
    case ShapeType::sphere:
      break;
  }
  const double half = shape.type == ShapeType::capsule ? shape.size[1] : 0.0;
  const double length = n.norm();
  const Vector3d offset = length > 1e-12 ? Vector3d(shape.size[0] / length * n) : Vector3d::Zero();
  return offset + Vector3d(0, 0, sign(n.z()) * half);
}

Vector3d support(const Shape& shape, const Pose& X_WS, const Vector3d& n_W) {
  return X_WS * local_support(shape, X_WS.linear().transpose() * n_W);
}

/// A vertex of the Minkowski difference A − B with the points it comes from.
struct Vertex {
  Vector3d a, b, v;
};

struct Simplex {
  std::array<Vertex, 4> vertices;
  std::array<double, 4> weights{};
  int size = 0;
};

/// Weights of the point nearest to the origin in the affine hull of the chosen vertices; false when they are
/// degenerate.
bool affine_weights(const Simplex& simplex, const std::array<int, 4>& chosen, int count,
                    std::array<double, 4>& weights) {
  if (count == 1) {
    weights[0] = 1;
    return true;
  }
  Eigen::Matrix<double, 3, Eigen::Dynamic, 0, 3, 3> edges(3, count - 1);
  const Vector3d& origin = simplex.vertices[chosen[0]].v;
  for (int i = 1; i < count; ++i) edges.col(i - 1) = simplex.vertices[chosen[i]].v - origin;
  const Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, 3, 3> gram = edges.transpose() * edges;
  const Eigen::FullPivLU<Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, 3, 3>> lu(gram);
  if (!lu.isInvertible()) return false;
  const Eigen::Matrix<double, Eigen::Dynamic, 1, 0, 3, 1> x = lu.solve(-(edges.transpose() * origin));
  weights[0] = 1 - x.sum();
  for (int i = 1; i < count; ++i) weights[i] = x[i - 1];
  return true;
}

/// Reduces the simplex to the smallest face that holds its point nearest to the origin; returns that point.
Vector3d nearest_to_origin(Simplex& simplex) {
  double best = std::numeric_limits<double>::infinity();
  Simplex reduced;
  Vector3d nearest = Vector3d::Zero();
  for (int mask = 1; mask < (1 << simplex.size); ++mask) {
    std::array<int, 4> chosen{};
    int count = 0;
    for (int i = 0; i < simplex.size; ++i) {
      if (mask & (1 << i)) chosen[count++] = i;
    }
    std::array<double, 4> weights{};
    if (!affine_weights(simplex, chosen, count, weights)) continue;
    Vector3d point = Vector3d::Zero();
    bool inside = true;
    for (int i = 0; i < count; ++i) {
      inside = inside && weights[i] >= 0;
      point += weights[i] * simplex.vertices[chosen[i]].v;
    }
    if (!inside || !(point.squaredNorm() < best)) continue;
    best = point.squaredNorm();
    nearest = point;
    reduced.size = count;
    for (int i = 0; i < count; ++i) {
      reduced.vertices[i] = simplex.vertices[chosen[i]];
      reduced.weights[i] = weights[i];
    }
  }
  simplex = reduced;
  return nearest;
}

/// GJK. True when the shapes are apart by more than rounding.
bool separated(const Shape& a, const Pose& X_WA, const Shape& b, const Pose& X_WB, Distance& result) {
  Simplex simplex;
  Vector3d nearest = X_WA.translation() - X_WB.translation();
  if (nearest.norm() < 1e-9) nearest = Vector3d::UnitX();
  for (int iteration = 0; iteration < 100; ++iteration) {
    Vertex vertex;
    vertex.a = support(a, X_WA, -nearest);
    vertex.b = support(b, X_WB, nearest);
    vertex.v = vertex.a - vertex.b;
    // The support plane bounds the distance from below: no more to gain than this.
    const double gain = nearest.squaredNorm() - nearest.dot(vertex.v);
    if (simplex.size > 0 && gain <= 1e-10 * nearest.norm()) break;
    simplex.vertices[simplex.size++] = vertex;
    nearest = nearest_to_origin(simplex);
    if (nearest.norm() < 1e-10 || simplex.size == 4) return false;
  }
  result.distance = nearest.norm();
  result.normal = result.gradient = nearest / result.distance;
  result.point_a.setZero();
  result.point_b.setZero();
  for (int i = 0; i < simplex.size; ++i) {
    result.point_a += simplex.weights[i] * simplex.vertices[i].a;
    result.point_b += simplex.weights[i] * simplex.vertices[i].b;
  }
  return true;
}

/// The smallest overlap over candidate axes (separating axis theorem).
Distance overlap(const Shape& a, const Pose& X_WA, const Shape& b, const Pose& X_WB) {
  Distance best;
  best.distance = -std::numeric_limits<double>::infinity();
  const auto try_axis = [&](const Vector3d& axis) {
    const double length = axis.norm();
    if (!(length > 1e-9)) return;
    for (const double sign : {1.0, -1.0}) {
      const Vector3d n = sign / length * axis;
      const Vector3d on_a = support(a, X_WA, -n), on_b = support(b, X_WB, n);
      const double distance = n.dot(on_a - on_b);
      if (distance > best.distance) {
        // One contact point shared by both: the overlap's two faces lie at ± half the depth around it.
        const Vector3d middle = 0.5 * (on_a + on_b);
        const double height = n.dot(middle);
        best = {distance, middle + (n.dot(on_a) - height) * n, middle + (n.dot(on_b) - height) * n, n, n};
      }
    }
  };
  for (int i = 0; i < 3; ++i) {
    try_axis(X_WA.linear().col(i));
    try_axis(X_WB.linear().col(i));
    for (int j = 0; j < 3; ++j) try_axis(X_WA.linear().col(i).cross(X_WB.linear().col(j)));
  }
  const Vector3d centres = X_WA.translation() - X_WB.translation();
  try_axis(centres);
  // A cylinder's side is felt across its axis.
  for (const auto* X : {&X_WA, &X_WB}) {
    const Vector3d axis = X->linear().col(2);
    try_axis(centres - centres.dot(axis) * axis);
  }
  return best;
}

}  // namespace

Distance convex_distance(const Shape& a, const Pose& X_WA, const Shape& b, const Pose& X_WB) {
  Distance result;
  if (separated(a, X_WA, b, X_WB, result)) return result;
  return overlap(a, X_WA, b, X_WB);
}

}  // namespace primo::robot
