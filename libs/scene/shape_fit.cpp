#include "scene/shape_fit.h"

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>

namespace primo::scene {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double kRobustScale = 0.003;  // m: residuals beyond it count less
constexpr double kRim = 0.006;          // m: points so near the top's edge are neither top nor side
constexpr double kSmallest = 0.0025, kLargest = 0.6;
constexpr std::size_t kFewest = 10;

double weight(double residual) { return 1 / (1 + residual * residual / (kRobustScale * kRobustScale)); }

double quantile(std::vector<double> values, double fraction) {
  const auto at = static_cast<std::ptrdiff_t>(fraction * static_cast<double>(values.size() - 1));
  std::nth_element(values.begin(), values.begin() + at, values.end());
  return values[static_cast<std::size_t>(at)];
}

/// The top's height from the points well inside the outline, which can only lie on the top; `before` when there are
/// few.
template <class Inside>
double top_height(const Points& points, double before, const Inside& inside) {
  std::vector<double> heights;
  for (const auto& p : points) {
    if (inside(p)) heights.push_back(p.z());
  }
  if (heights.size() < kFewest) return before;
  const double median = quantile(heights, 0.5);
  double sum = 0, total = 0;
  for (const double z : heights) {
    sum += weight(z - median) * z;
    total += weight(z - median);
  }
  return sum / total;
}

double initial_top(const Points& points) {
  std::vector<double> heights;
  heights.reserve(points.size());
  for (const auto& p : points) heights.push_back(p.z());
  return quantile(std::move(heights), 0.98);
}

struct Circle {
  Vector2d centre{0, 0};
  double radius = 0;
};

/// Algebraic circle (Kåsa 1976), the start of the geometric one.
std::optional<Circle> algebraic_circle(const Points& points) {
  Vector2d mean = Vector2d::Zero();
  for (const auto& p : points) mean += p.head<2>();
  mean /= static_cast<double>(points.size());
  Eigen::Matrix3d A = Eigen::Matrix3d::Zero();
  Vector3d b = Vector3d::Zero();
  for (const auto& p : points) {
    const Vector2d d = p.head<2>() - mean;
    const Vector3d row(d.x(), d.y(), 1);
    A += row * row.transpose();
    b += row * d.squaredNorm();
  }
  A.diagonal().array() += 1e-9;
  const Vector3d x = A.ldlt().solve(b);
  const Vector2d centre = x.head<2>() / 2;
  const double squared = x.z() + centre.squaredNorm();
  if (!x.allFinite() || !(squared > 0)) return std::nullopt;
  return Circle{mean + centre, std::sqrt(squared)};
}

/// Gauss–Newton on the weighted distances |p − c| − r.
std::optional<Circle> geometric_circle(const Points& points, Circle circle) {
  for (int iteration = 0; iteration < 25; ++iteration) {
    Eigen::Matrix3d H = Eigen::Matrix3d::Identity() * 1e-9;
    Vector3d g = Vector3d::Zero();
    for (const auto& p : points) {
      const Vector2d d = p.head<2>() - circle.centre;
      const double length = std::max(d.norm(), 1e-9), residual = length - circle.radius, w = weight(residual);
      const Vector3d row(-d.x() / length, -d.y() / length, -1);
      H += w * row * row.transpose();
      g += w * residual * row;
    }
    Vector3d step = -H.ldlt().solve(g);
    if (!step.allFinite()) return std::nullopt;
    if (step.norm() > 0.05) step *= 0.05 / step.norm();
    circle.centre += step.head<2>();
    circle.radius = std::max(circle.radius + step.z(), 1e-4);
    if (step.norm() < 1e-7) break;
  }
  return circle;
}

double rms(const ShapeFit& fit, const Points& points) {
  double sum = 0;
  for (const auto& p : points) sum += std::pow(fit.distance(p), 2);
  return std::sqrt(sum / static_cast<double>(points.size()));
}

bool sensible(double size) { return size >= kSmallest && size <= kLargest; }

/// Convex hull, counter-clockwise (Andrew's monotone chain).
std::vector<Vector2d> convex_hull(const Points& points) {
  std::vector<Vector2d> sorted;
  sorted.reserve(points.size());
  for (const auto& p : points) sorted.emplace_back(p.head<2>());
  std::sort(sorted.begin(), sorted.end(),
            [](const Vector2d& a, const Vector2d& b) { return a.x() < b.x() || (a.x() == b.x() && a.y() < b.y()); });
  const auto left_turn = [](const Vector2d& o, const Vector2d& a, const Vector2d& b) {
    return (a.x() - o.x()) * (b.y() - o.y()) - (a.y() - o.y()) * (b.x() - o.x()) > 0;
  };
  std::vector<Vector2d> hull;
  for (int pass = 0; pass < 2; ++pass) {
    const std::size_t begin = hull.size();
    for (const auto& p : sorted) {
      while (hull.size() >= begin + 2 && !left_turn(hull[hull.size() - 2], hull.back(), p)) hull.pop_back();
      hull.push_back(p);
    }
    hull.pop_back();
    std::reverse(sorted.begin(), sorted.end());
  }
  return hull;
}

/// A rectangle by its angle and the offsets of its faces along +u, +v, −u, −v from `origin`.
struct Rectangle {
  Vector2d origin{0, 0};
  double angle = 0;
  std::array<double, 4> offset{};

  Vector2d normal(int face) const {
    const double a = angle + face * std::numbers::pi / 2;
    return {std::cos(a), std::sin(a)};
  }
  std::array<Vector2d, 4> normals() const { return {normal(0), normal(1), normal(2), normal(3)}; }
};

/// The smallest rectangle around the points: one of its sides lies along a side of their hull (Freeman, Shapira 1975).
std::optional<Rectangle> smallest_rectangle(const Points& points) {
  const auto hull = convex_hull(points);
  if (hull.size() < 3) return std::nullopt;
  Rectangle best;
  double best_area = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < hull.size(); ++i) {
    const Vector2d edge = hull[(i + 1) % hull.size()] - hull[i];
    Rectangle candidate;
    candidate.origin = hull[0];
    candidate.angle = std::atan2(edge.y(), edge.x());
    for (int face = 0; face < 4; ++face) {
      double& offset = candidate.offset[static_cast<std::size_t>(face)];
      const Vector2d normal = candidate.normal(face);
      offset = -std::numeric_limits<double>::infinity();
      for (const auto& p : hull) offset = std::max(offset, normal.dot(p - candidate.origin));
    }
    const double area = (candidate.offset[0] + candidate.offset[2]) * (candidate.offset[1] + candidate.offset[3]);
    if (area < best_area) {
      best_area = area;
      best = candidate;
    }
  }
  return best;
}

/// The face that p, relative to the rectangle's origin, lies farthest outside of, and by how much.
struct FaceDistance {
  std::size_t face = 0;
  double distance = -std::numeric_limits<double>::infinity();
};

FaceDistance nearest_face(const Rectangle& rectangle, const std::array<Vector2d, 4>& normals, const Vector2d& p) {
  FaceDistance nearest;
  for (std::size_t face = 0; face < 4; ++face) {
    const double distance = normals[face].dot(p) - rectangle.offset[face];
    if (distance > nearest.distance) nearest = {face, distance};
  }
  return nearest;
}

/// Gauss–Newton on the angle and the offsets of all faces at once. Faces that few points see keep their offset.
/// `sides`: relative to the rectangle's origin.
bool refine(Rectangle& rectangle, const std::vector<Vector2d>& sides) {
  for (int iteration = 0; iteration < 20; ++iteration) {
    const auto normals = rectangle.normals();
    // A point's residual depends on the angle and on its face's offset only: of H no more than an arrow is filled.
    Eigen::Matrix<double, 5, 5> H = Eigen::Matrix<double, 5, 5>::Identity() * 1e-9;
    Eigen::Matrix<double, 5, 1> g = Eigen::Matrix<double, 5, 1>::Zero();
    for (const auto& r : sides) {
      const auto [face, residual] = nearest_face(rectangle, normals, r);
      const Vector2d& n = normals[face];
      const auto offset = static_cast<Eigen::Index>(face) + 1;
      const double w = weight(residual), turn = -n.y() * r.x() + n.x() * r.y();
      H(0, 0) += w * turn * turn;
      H(offset, 0) -= w * turn;
      H(offset, offset) += w;
      g[0] += w * residual * turn;
      g[offset] -= w * residual;
    }
    const Eigen::Matrix<double, 5, 1> step = -H.ldlt().solve(g);  // reads the lower triangle
    if (!step.allFinite()) return false;
    rectangle.angle += std::clamp(step[0], -0.1, 0.1);
    for (int face = 0; face < 4; ++face)
      rectangle.offset[static_cast<std::size_t>(face)] += std::clamp(step[face + 1], -0.02, 0.02);
    if (step.norm() < 1e-7) break;
  }
  return true;
}

ShapeFit make_box(const Rectangle& rectangle, double table_z, double top) {
  const Vector2d u = rectangle.normal(0), v = rectangle.normal(1);
  const double width = rectangle.offset[0] + rectangle.offset[2], depth = rectangle.offset[1] + rectangle.offset[3];
  const Vector2d centre = rectangle.origin + u * (rectangle.offset[0] - rectangle.offset[2]) / 2 +
                          v * (rectangle.offset[1] - rectangle.offset[3]) / 2;
  // The one of four equal poses with yaw in (−45°, 45°].
  const double quarter = std::numbers::pi / 2;
  const double turns = std::ceil((rectangle.angle - quarter / 2) / quarter);
  const bool swapped = std::fmod(std::abs(turns), 2) == 1;
  ShapeFit fit;
  fit.type = ShapeType::box;
  fit.X_WO =
      pose(Vector3d(centre.x(), centre.y(), (top + table_z) / 2), Vector3d(0, 0, rectangle.angle - turns * quarter));
  fit.shape = {ShapeType::box, {(swapped ? depth : width) / 2, (swapped ? width : depth) / 2, (top - table_z) / 2}};
  return fit;
}

/// Whether no box needs to be tried: the cylinder leaves no more than noise, it is so wide that a box would leave more
/// (the rms distance of a square from the circle that fits it best is 0.105 of the radius), and its points span it, as
/// those of one flat face do not.
bool certainly(const ShapeFit& cylinder, const Points& points, double noise) {
  const double radius = cylinder.shape.size.x();
  if (cylinder.residual > noise || radius < 12 * noise) return false;
  Eigen::AlignedBox2d extent;
  for (const auto& p : points) extent.extend(p.head<2>());
  return extent.sizes().minCoeff() >= 1.8 * radius;
}

}  // namespace

double ShapeFit::distance(const Vector3d& p_W) const {
  const Vector3d p = X_WO.inverse(Eigen::Isometry) * p_W;
  double side = 0;
  double over = 0;
  if (type == ShapeType::cylinder) {
    side = p.head<2>().norm() - shape.size.x();
    over = p.z() - shape.size.y();
  } else {
    const Vector2d d = p.head<2>().cwiseAbs() - shape.size.head<2>();
    side = d.maxCoeff() <= 0 ? d.maxCoeff() : d.cwiseMax(0).norm();
    over = p.z() - shape.size.z();
  }
  return side > 0 && over > 0 ? std::hypot(side, over) : std::max(side, over);
}

std::optional<ShapeFit> fit_cylinder(const Points& points, double table_z, double min_height) {
  if (points.size() < kFewest) return std::nullopt;
  double top = initial_top(points);
  std::optional<Circle> circle;
  for (int round = 0; round < 3; ++round) {
    Points sides;
    for (const auto& p : points) {
      const bool side = p.z() < top - kRim;
      if (side && (!circle || (p.head<2>() - circle->centre).norm() > 0.7 * circle->radius)) sides.push_back(p);
    }
    if (sides.size() < kFewest) return std::nullopt;
    if (!circle) circle = algebraic_circle(sides);
    if (circle) circle = geometric_circle(sides, *circle);
    if (!circle || !sensible(circle->radius)) return std::nullopt;
    const double inside = circle->radius - std::max(kRim, 0.15 * circle->radius);
    top = top_height(points, top, [&](const Vector3d& p) { return (p.head<2>() - circle->centre).norm() < inside; });
  }
  if (!(top - table_z >= min_height)) return std::nullopt;
  ShapeFit fit;
  fit.type = ShapeType::cylinder;
  fit.X_WO = pose(Vector3d(circle->centre.x(), circle->centre.y(), (top + table_z) / 2));
  fit.shape = {ShapeType::cylinder, {circle->radius, (top - table_z) / 2, 0}};
  fit.residual = rms(fit, points);
  return fit;
}

std::optional<ShapeFit> fit_box(const Points& points, double table_z, double min_height) {
  if (points.size() < kFewest) return std::nullopt;
  double top = initial_top(points);
  auto rectangle = smallest_rectangle(points);
  if (!rectangle) return std::nullopt;
  for (int round = 0; round < 3; ++round) {
    std::vector<Vector2d> sides;
    for (const auto& p : points) {
      if (p.z() < top - kRim) sides.emplace_back(p.head<2>() - rectangle->origin);
    }
    if (sides.size() >= kFewest && !refine(*rectangle, sides)) return std::nullopt;
    const auto normals = rectangle->normals();
    top = top_height(points, top, [&](const Vector3d& p) {
      const Vector2d r = p.head<2>() - rectangle->origin;
      const std::size_t face = nearest_face(*rectangle, normals, r).face;
      return normals[face].dot(r) < rectangle->offset[face] - kRim;
    });
  }
  ShapeFit fit = make_box(*rectangle, table_z, top);
  if (!(top - table_z >= min_height) || !sensible(fit.shape.size.x()) || !sensible(fit.shape.size.y())) {
    return std::nullopt;
  }
  fit.residual = rms(fit, points);
  return fit;
}

std::optional<ShapeFit> fit_shape(const Points& points, double table_z, double min_height, double noise) {
  const auto cylinder = fit_cylinder(points, table_z, min_height);
  if (cylinder && certainly(*cylinder, points, noise)) return cylinder;
  const auto box = fit_box(points, table_z, min_height);
  if (cylinder && box) return cylinder->residual <= box->residual ? cylinder : box;
  return cylinder ? cylinder : box;
}

}  // namespace primo::scene
