#include "symbols/snapshot.h"

#include <cmath>

namespace primo::symbols {
namespace {

/// Half the size of the body's box along a unit direction d_W: the support function of a centred box or cylinder.
double half_size(const SnapshotBody& body, const Eigen::Vector3d& d_W) {
  const Eigen::Vector3d d = body.X_WB.linear().transpose() * d_W;
  if (body.kind == BodyKind::cylinder) {
    return body.half_extents.x() * std::hypot(d.x(), d.y()) + body.half_extents.z() * std::abs(d.z());
  }
  return body.half_extents.dot(d.cwiseAbs());
}

}  // namespace

const SnapshotBody* WorldSnapshot::body(const std::string& name) const {
  for (const auto& body : bodies) {
    if (body.name == name) return &body;
  }
  return nullptr;
}

double top_height(const SnapshotBody& body) {
  return body.X_WB.translation().z() + half_size(body, Eigen::Vector3d::UnitZ());
}

double bottom_height(const SnapshotBody& body) {
  return body.X_WB.translation().z() - half_size(body, Eigen::Vector3d::UnitZ());
}

bool above_footprint(const SnapshotBody& body, const Eigen::Vector3d& p_W) {
  const Eigen::Vector3d p = p_W - body.X_WB.translation();
  if (body.kind == BodyKind::cylinder && std::abs(body.X_WB.linear()(2, 2)) > 0.99) {
    return std::hypot(p.x(), p.y()) <= body.half_extents.x();
  }
  if (std::abs(body.X_WB.linear()(2, 2)) > 0.99) {
    const Eigen::Vector3d p_B = body.X_WB.linear().transpose() * Eigen::Vector3d(p.x(), p.y(), 0);
    return std::abs(p_B.x()) <= body.half_extents.x() && std::abs(p_B.y()) <= body.half_extents.y();
  }
  return std::abs(p.x()) <= half_size(body, Eigen::Vector3d::UnitX()) &&
         std::abs(p.y()) <= half_size(body, Eigen::Vector3d::UnitY());
}

}  // namespace primo::symbols
