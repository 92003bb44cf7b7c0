#include "physics/contact_filter.h"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <mutex>

namespace primo::physics {
namespace {

/// One geom where it is.
struct Placed {
  Placed(const mjModel* model, const mjData* data, int geom)
      : type(model->geom_type[geom]),
        size(model->geom_size + 3 * geom),
        radius(model->geom_rbound[geom]),
        centre(data->geom_xpos + 3 * geom),
        R(data->geom_xmat + 9 * geom) {}

  /// How far the geom extends from its centre along a unit vector, m; at most.
  double extent(const Eigen::Vector3d& along) const {
    const double c = std::abs(R.col(2).dot(along));
    switch (type) {
      case mjGEOM_BOX:
        return size[0] * std::abs(R.col(0).dot(along)) + size[1] * std::abs(R.col(1).dot(along)) + size[2] * c;
      case mjGEOM_CYLINDER:
        return size[1] * c + size[0] * std::sqrt(std::max(0.0, 1 - c * c));
      case mjGEOM_CAPSULE:
        return size[1] * c + size[0];
      default:
        return radius;
    }
  }

  int type;
  Eigen::Map<const Eigen::Vector3d> size;
  double radius;
  Eigen::Map<const Eigen::Vector3d> centre;
  Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>> R;
};

int skip(const mjModel* model, mjData* data, int a, int b) {
  const bool collide = (model->geom_contype[a] & model->geom_conaffinity[b]) != 0 ||
                       (model->geom_contype[b] & model->geom_conaffinity[a]) != 0;
  return !collide || surely_apart(model, data, a, b) ? 1 : 0;
}

}  // namespace

bool surely_apart(const mjModel* model, const mjData* data, int geom_a, int geom_b) {
  constexpr double kSlack = 1e-6;  // m, far beyond rounding
  const Placed a(model, data, geom_a), b(model, data, geom_b);
  if (a.radius <= 0 || b.radius <= 0) return false;  // planes
  const double margin = std::max(model->geom_margin[geom_a], model->geom_margin[geom_b]) + kSlack;
  const Eigen::Vector3d between = b.centre - a.centre;
  const double far = a.radius + b.radius + margin;
  if (between.squaredNorm() > far * far) return true;
  const auto apart = [&](const Eigen::Vector3d& axis) {
    return std::abs(axis.dot(between)) > a.extent(axis) + b.extent(axis) + margin;
  };
  for (int i = 2; i >= 0; --i) {
    if (apart(a.R.col(i)) || apart(b.R.col(i))) return true;
  }
  const double distance = between.norm();
  return distance > 0 && apart(between / distance);
}

void use_contact_filter() {
  static std::once_flag once;
  std::call_once(once, [] { mjcb_contactfilter = skip; });
}

}  // namespace primo::physics
