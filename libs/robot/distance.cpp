#include "robot/distance.h"

#include <algorithm>
#include <cmath>

#include "robot/convex.h"

namespace primo::robot {
namespace {

using Eigen::Vector3d;

constexpr double kTiny = 1e-12;

/// v / |v|, or `otherwise` where v has no direction.
Vector3d direction(const Vector3d& v, const Vector3d& otherwise) {
  const double length = v.norm();
  return length > kTiny ? Vector3d(v / length) : otherwise;
}

/// A sphere or a capsule: all points within `radius` of a segment from `a` along `d`.
struct Segment {
  Vector3d a, d;
  double radius;
};

bool is_round(const Shape& shape) { return shape.type == ShapeType::sphere || shape.type == ShapeType::capsule; }

Segment segment(const Shape& shape, const Pose& X_WS) {
  if (shape.type == ShapeType::sphere) return {X_WS.translation(), Vector3d::Zero(), shape.size[0]};
  const Vector3d half = shape.size[1] * X_WS.linear().col(2);
  return {X_WS.translation() - half, 2.0 * half, shape.size[0]};
}

/// Closest points of two segments (Ericson, Real-Time Collision Detection, 2005, 5.1.9); degenerate segments are
/// points.
void closest_on_segments(const Segment& p, const Segment& q, double& s, double& t) {
  const Vector3d r = p.a - q.a;
  const double a = p.d.squaredNorm(), e = q.d.squaredNorm(), f = q.d.dot(r), c = p.d.dot(r);
  const double epsilon = kTiny * kTiny;
  if (a <= epsilon) {
    s = 0;
    t = e <= epsilon ? 0 : std::clamp(f / e, 0.0, 1.0);
    return;
  }
  if (e <= epsilon) {
    t = 0;
    s = std::clamp(-c / a, 0.0, 1.0);
    return;
  }
  const double b = p.d.dot(q.d), denominator = a * e - b * b;
  s = denominator > 1e-14 * a * e ? std::clamp((b * f - c * e) / denominator, 0.0, 1.0) : 0.0;
  t = (b * s + f) / e;
  if (t < 0) {
    t = 0;
    s = std::clamp(-c / a, 0.0, 1.0);
  } else if (t > 1) {
    t = 1;
    s = std::clamp((b - c) / a, 0.0, 1.0);
  }
}

Distance round_to_round(const Segment& a, const Segment& b) {
  double s = 0, t = 0;
  closest_on_segments(a, b, s, t);
  const Vector3d on_a = a.a + s * a.d, on_b = b.a + t * b.d;
  // Crossing axes leave the direction open: any unit vector across both is as good.
  Vector3d across = a.d.cross(b.d);
  if (across.norm() < kTiny) across = (a.d.norm() > kTiny ? a.d : b.d).unitOrthogonal();
  if (!(across.norm() > kTiny)) across = Vector3d::UnitZ();
  Distance result;
  result.normal = direction(on_a - on_b, across.normalized());
  result.distance = (on_a - on_b).norm() - a.radius - b.radius;
  result.gradient = result.normal;
  result.point_a = on_a - a.radius * result.normal;
  result.point_b = on_b + b.radius * result.normal;
  return result;
}

double signed_distance_box(const Vector3d& half, const Vector3d& p, Vector3d& normal) {
  const Vector3d q = p.cwiseAbs() - half;
  const auto sign = [&](int i) { return p[i] < 0 ? -1.0 : 1.0; };
  int deepest = 0;
  const double most = q.maxCoeff(&deepest);
  if (most <= 0) {
    normal = sign(deepest) * Vector3d::Unit(deepest);
    return most;
  }
  for (int i = 0; i < 3; ++i) normal[i] = sign(i) * std::max(q[i], 0.0);
  const double length = normal.norm();
  normal = length > 0 ? Vector3d(normal / length) : Vector3d(sign(deepest) * Vector3d::Unit(deepest));
  return length;
}

double signed_distance_cylinder(double radius, double half, const Vector3d& p, Vector3d& normal) {
  const double rho = std::sqrt(p.x() * p.x() + p.y() * p.y());
  const Vector3d radial = rho > kTiny ? Vector3d(p.x() / rho, p.y() / rho, 0) : Vector3d::UnitX();
  const Vector3d axial = p.z() < 0 ? Vector3d(-Vector3d::UnitZ()) : Vector3d(Vector3d::UnitZ());
  const double dr = rho - radius, dz = std::abs(p.z()) - half;
  if (dr <= 0 || dz <= 0) {
    // Inside, or nearest to the side or a cap alone.
    const bool side = dr > dz;
    normal = side ? radial : axial;
    return side ? dr : dz;
  }
  const double length = std::sqrt(dr * dr + dz * dz);
  normal = length > 0 ? Vector3d((dr * radial + dz * axial) / length) : radial;
  return length;
}

/// Where the convex function sd(a + s d) is least on [0, 1], and its gradient under displacements there.
struct Deepest {
  double s = 0;
  Vector3d gradient;
};

/// Where the segment a + s d comes nearest to a cylinder's axis, if it is there outside of the side and between the
/// caps: the distance is then least there, too.
bool nearest_to_side(const Shape& cylinder, const Vector3d& a, const Vector3d& d, Deepest& nearest) {
  const double across = d.x() * d.x() + d.y() * d.y();
  const double s = across > 0 ? std::clamp(-(a.x() * d.x() + a.y() * d.y()) / across, 0.0, 1.0) : 0.0;
  const Vector3d p = a + s * d;
  const double rho = std::sqrt(p.x() * p.x() + p.y() * p.y());
  if (!(rho > cylinder.size[0]) || !(std::abs(p.z()) < cylinder.size[1])) return false;
  nearest = {s, {p.x() / rho, p.y() / rho, 0}};
  return true;
}

/// The root of the increasing slope n(s)·d, by false position with the Illinois weights (Dowell and Jarratt, 1971) and
/// bisection where these are slow. Where the slope jumps over zero (an axis inside a solid, equally near to two of its
/// faces), the gradient of the minimum is the mean of both normals that has no slope along the axis.
Deepest deepest_on_segment(const Shape& solid, const Vector3d& a, const Vector3d& d) {
  Vector3d normal;
  const auto slope = [&](double s) {
    signed_distance(solid, a + s * d, normal);
    return normal.dot(d);
  };
  double lo = 0, hi = 1, f_lo = slope(lo);
  if (f_lo >= 0) return {lo, normal};
  Vector3d n_lo = normal;
  double f_hi = slope(hi);
  if (f_hi <= 0) return {hi, normal};
  Vector3d n_hi = normal;
  const double flat = 1e-10 * d.norm();
  double weight_lo = 1, weight_hi = 1, wide = 1;  // `wide`: the bracket at the last check
  bool rising = false, falling = false;           // which end moved last
  for (int i = 0; i < 80 && hi - lo > 1e-10; ++i) {
    const double below = weight_lo * f_lo, above = weight_hi * f_hi;
    double s = lo - below * (hi - lo) / (above - below);
    if (i % 4 == 3) {
      if (hi - lo > 0.5 * wide) s = 0.5 * (lo + hi);
      wide = hi - lo;
    }
    s = std::clamp(s, lo + 1e-12, hi - 1e-12);
    const double f = slope(s);
    if (std::abs(f) <= flat) return {s, normal};
    // An end that stays twice counts half, so that it moves, too.
    if (f < 0) {
      lo = s;
      f_lo = f;
      n_lo = normal;
      weight_lo = 1;
      if (rising) weight_hi *= 0.5;
    } else {
      hi = s;
      f_hi = f;
      n_hi = normal;
      weight_hi = 1;
      if (falling) weight_lo *= 0.5;
    }
    rising = f < 0;
    falling = !rising;
  }
  return {0.5 * (lo + hi), (f_hi * n_lo - f_lo * n_hi) / (f_hi - f_lo)};
}

Distance round_to_solid(const Segment& a, const Shape& solid, const Pose& X_WB) {
  const Eigen::Matrix3d R_BW = X_WB.linear().transpose();
  const Vector3d start = R_BW * (a.a - X_WB.translation()), d = R_BW * a.d;
  Deepest deepest;
  const bool is_point = d.squaredNorm() <= kTiny * kTiny;
  if (!is_point && !(solid.type == ShapeType::cylinder && nearest_to_side(solid, start, d, deepest)))
    deepest = deepest_on_segment(solid, start, d);
  const Vector3d p = start + deepest.s * d;
  Vector3d normal;
  const double axis_distance = signed_distance(solid, p, normal);
  if (is_point) deepest.gradient = normal;
  Distance result;
  result.distance = axis_distance - a.radius;
  result.gradient = X_WB.linear() * deepest.gradient;
  result.normal = direction(result.gradient, X_WB.linear() * normal);
  const Vector3d p_W = X_WB * p;
  result.point_a = p_W - a.radius * result.normal;
  result.point_b = p_W - axis_distance * result.normal;
  return result;
}

Distance swapped(Distance d) {
  std::swap(d.point_a, d.point_b);
  d.normal = -d.normal;
  d.gradient = -d.gradient;
  return d;
}

}  // namespace

double signed_distance(const Shape& shape, const Vector3d& p_B, Vector3d& normal) {
  switch (shape.type) {
    case ShapeType::box:
      return signed_distance_box(shape.size, p_B, normal);
    case ShapeType::cylinder:
      return signed_distance_cylinder(shape.size[0], shape.size[1], p_B, normal);
    case ShapeType::capsule:
    case ShapeType::sphere:
      break;
  }
  const double half = shape.type == ShapeType::capsule ? shape.size[1] : 0.0;
  const Vector3d from_axis(p_B.x(), p_B.y(), p_B.z() - std::clamp(p_B.z(), -half, half));
  normal = direction(from_axis, Vector3d::UnitX());
  return from_axis.norm() - shape.size[0];
}

bool may_be_within(const Shape& a, const Pose& X_WA, const Shape& b, const Pose& X_WB, double margin) {
  if (is_round(b)) return true;
  const Eigen::Matrix3d R_BW = X_WB.linear().transpose();
  const Vector3d centre = R_BW * (X_WA.translation() - X_WB.translation());
  // The box about b against the box about a's axis, or about a's centre, widened.
  const Vector3d half = b.type == ShapeType::box ? b.size : Vector3d(b.size[0], b.size[0], b.size[1]);
  const double reach = margin + (is_round(a) ? a.size[0] : bounding_radius(a));
  Vector3d extent = half.array() + reach;
  if (a.type == ShapeType::capsule) extent += (a.size[1] * (R_BW * X_WA.linear().col(2))).cwiseAbs();
  return (centre.cwiseAbs().array() < extent.array()).all();
}

Distance distance(const Shape& a, const Pose& X_WA, const Shape& b, const Pose& X_WB) {
  if (is_round(a)) {
    if (is_round(b)) return round_to_round(segment(a, X_WA), segment(b, X_WB));
    return round_to_solid(segment(a, X_WA), b, X_WB);
  }
  if (is_round(b)) return swapped(round_to_solid(segment(b, X_WB), a, X_WA));
  return convex_distance(a, X_WA, b, X_WB);
}

double bounding_radius(const Shape& shape) {
  switch (shape.type) {
    case ShapeType::sphere:
      return shape.size[0];
    case ShapeType::capsule:
      return shape.size[0] + shape.size[1];
    case ShapeType::cylinder:
      return std::hypot(shape.size[0], shape.size[1]);
    case ShapeType::box:
      return shape.size.norm();
  }
  return 0;
}

}  // namespace primo::robot
