// Exact Euclidean distance transform of an occupancy map (Felzenszwalb and Huttenlocher, Distance Transforms of Sampled
// Functions, 2012, section 2.1, one axis after the other), with the occupied voxel that is closest.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "core/result.h"
#include "scene/occupancy_map.h"

namespace primo::scene {

/// Distances from voxel centres to the nearest occupied voxel's centre, on a regular grid over a region. Voxel i along
/// an axis has its centre at origin + (i + ½) · resolution.
class DistanceField {
 public:
  /// `occupied` are points in W; those outside the region are left out. Errors (data): an empty or absurd region (more
  /// than 2²⁶ voxels), a resolution that is not positive.
  static Result<DistanceField> build(const std::vector<Eigen::Vector3d>& occupied, const Region& region,
                                     double resolution);

  /// m, to the nearest occupied voxel centre from the centre of the voxel that holds p; p outside the region is first
  /// clamped to it. infinite_distance() where nothing is occupied.
  double distance(const Eigen::Vector3d& p_W) const;
  /// Centre of that nearest voxel. @pre something is occupied.
  Eigen::Vector3d closest(const Eigen::Vector3d& p_W) const;
  /// Distance at any point with its gradient (unit-free), m: inside the grid of voxel centres trilinear between the
  /// distances at the eight centres around p; outside √(e² + d²), e the distance to the grid and d the value at the
  /// grid's closest point c, which is never more than the distance of what lies in the grid, as that is convex.
  /// Continuous; the gradient is that of the formula, one-sided at the faces between cells. infinite_distance() and a
  /// zero gradient where nothing is occupied.
  double interpolate(const Eigen::Vector3d& p_W, Eigen::Vector3d& gradient) const;
  bool empty() const { return empty_; }

  const Eigen::Vector3i& size() const { return size_; }
  double resolution() const { return resolution_; }
  Eigen::Vector3d centre(const Eigen::Vector3i& voxel) const {
    return origin_ + (voxel.cast<double>().array() + 0.5).matrix() * resolution_;
  }
  static constexpr double infinite_distance() { return 1e9; }

 private:
  std::size_t index(const Eigen::Vector3d& p_W) const;
  double trilinear(const Eigen::Vector3d& voxels, Eigen::Vector3d& gradient) const;
  Eigen::Vector3d origin_{0, 0, 0};
  Eigen::Vector3i size_{0, 0, 0};
  double resolution_ = 0;
  bool empty_ = true;
  std::vector<float> squared_;          // in voxels
  std::vector<std::uint32_t> nearest_;  // index of the closest occupied voxel
};

/// A field over occupied voxel centres of a map of this resolution and `margin` around them, on the map's own grid;
/// over one voxel at the origin where nothing is occupied. Errors: as build().
Result<DistanceField> distance_field(const std::vector<Eigen::Vector3d>& occupied, double resolution, double margin);

/// The field of a perceived scene over the table's extent and `margin` around it, from 0.1 m below the top to `height`
/// above it. Errors: as from_bytes() and build().
Result<DistanceField> distance_field(const SceneEstimate& estimate, double margin = 0.25, double height = 0.7);

}  // namespace primo::scene
