// Upright shapes fitted to the points of one object that stands on a level table: side faces by robust least squares on
// the distance to the surface, tops by the mean of the points inside the outline.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "core/pose.h"
#include "robot/shape.h"

namespace primo::scene {

using Points = std::vector<Eigen::Vector3d>;  // m in W

struct ShapeFit {
  ShapeType type = ShapeType::cylinder;
  Pose X_WO = Pose::Identity();
  Shape shape;
  double residual = 0;  ///< m, rms distance of the points to the surface

  /// m, signed distance of p to the surface; the hidden bottom counts as open.
  double distance(const Eigen::Vector3d& p_W) const;
};

/// Fits by type. Nothing, when there are fewer than 10 points or they determine no shape of sensible size (radius and
/// half extents 2.5 mm … 0.6 m, height at least `min_height`). The bottom is at table_z.
std::optional<ShapeFit> fit_cylinder(const Points& points, double table_z, double min_height);
std::optional<ShapeFit> fit_box(const Points& points, double table_z, double min_height);

/// The better of the two by residual. `noise`: m rms, what a shape leaves that fits; a cylinder that leaves no more,
/// and can be no box, is not compared with one.
std::optional<ShapeFit> fit_shape(const Points& points, double table_z, double min_height, double noise);

}  // namespace primo::scene
