#include "robot/mesh_cover.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "robot/distance.h"
#include "robot/mjcf.h"

namespace primo::robot {
namespace {

constexpr double kThinnest = 1e-4;  // m, half: a flat mesh's box must not be empty

/// The capsule along `axis` that holds all points, given about their centre.
Cover capsule(const Eigen::Matrix3Xd& points, int axis) {
  const Eigen::Array3d across = Eigen::Array3d::Ones() - Eigen::Array3d(Eigen::Vector3d::Unit(axis));
  double radius = kThinnest;
  for (const auto& p : points.colwise()) radius = std::max(radius, (p.array() * across).matrix().norm());
  double half_length = 0;
  for (const auto& p : points.colwise()) {
    const double aside = (p.array() * across).matrix().squaredNorm();
    half_length = std::max(half_length, std::abs(p[axis]) - std::sqrt(std::max(0.0, radius * radius - aside)));
  }
  Cover found{{ShapeType::capsule, {radius, half_length, 0}}};
  found.X_MS.linear() =
      Eigen::Quaterniond::FromTwoVectors(Eigen::Vector3d::UnitZ(), Eigen::Vector3d::Unit(axis)).toRotationMatrix();
  return found;
}

double volume(const Shape& shape) {
  const double r = shape.size[0];
  switch (shape.type) {
    case ShapeType::sphere:
      return 4.0 / 3.0 * std::numbers::pi * r * r * r;
    case ShapeType::capsule:
      return std::numbers::pi * r * r * (4.0 / 3.0 * r + 2 * shape.size[1]);
    case ShapeType::cylinder:
      return 2 * std::numbers::pi * r * r * shape.size[1];
    case ShapeType::box:
      break;
  }
  return 8 * shape.size.prod();
}

void replace(mjModel& model, int g, const Cover& cover) {
  constexpr std::array kTypes = {mjGEOM_SPHERE, mjGEOM_CAPSULE, mjGEOM_CYLINDER, mjGEOM_BOX};
  Eigen::Map<Eigen::Vector3d> p(model.geom_pos + 3 * g);
  double* wxyz = model.geom_quat + 4 * g;
  const Pose X_BS = pose(Eigen::Vector3d(p), Eigen::Quaterniond(wxyz[0], wxyz[1], wxyz[2], wxyz[3])) * cover.X_MS;
  const Eigen::Quaterniond turned = quaternion(X_BS);
  p = X_BS.translation();
  wxyz[0] = turned.w(), wxyz[1] = turned.x(), wxyz[2] = turned.y(), wxyz[3] = turned.z();
  Eigen::Map<Eigen::Vector3d>(model.geom_size + 3 * g) = cover.shape.size;
  model.geom_type[g] = kTypes[static_cast<std::size_t>(cover.shape.type)];
  model.geom_dataid[g] = -1;
  model.geom_rbound[g] = bounding_radius(cover.shape);
  model.geom_sameframe[g] = 0;
}

}  // namespace

Cover cover(const Eigen::Ref<const Eigen::Matrix3Xf>& points) {
  const Eigen::Vector3d low = points.rowwise().minCoeff().cast<double>(),
                        high = points.rowwise().maxCoeff().cast<double>();
  const Eigen::Vector3d centre = 0.5 * (low + high);
  const Eigen::Matrix3Xd about = points.cast<double>().colwise() - centre;
  int longest = 0;
  (high - low).maxCoeff(&longest);
  Cover best{{ShapeType::box, (0.5 * (high - low)).cwiseMax(kThinnest)}};
  const Cover ball{{ShapeType::sphere, {std::max(kThinnest, about.colwise().norm().maxCoeff()), 0, 0}}};
  for (const Cover& other : {capsule(about, longest), ball}) {
    if (volume(other.shape) < volume(best.shape)) best = other;
  }
  best.X_MS.translation() = centre;
  return best;
}

Status cover_meshes(mjModel& model, const std::string& where) {
  for (int g = 0; g < model.ngeom; ++g) {
    if (model.geom_type[g] != mjGEOM_MESH || (model.geom_contype[g] == 0 && model.geom_conaffinity[g] == 0)) continue;
    const int mesh = model.geom_dataid[g];
    const int count = mesh < 0 ? 0 : model.mesh_vertnum[mesh];
    const Eigen::Map<const Eigen::Matrix3Xf> points(count ? model.mesh_vert + 3 * model.mesh_vertadr[mesh] : nullptr, 3,
                                                    count);
    if (count == 0 || !points.allFinite()) {
      return Error{Code::config, where + ": geom '" + name_of(model, mjOBJ_GEOM, g) +
                                     "' collides and its mesh has no vertices, or one that is not finite"};
    }
    replace(model, g, cover(points));
  }
  return success();
}

}  // namespace primo::robot
