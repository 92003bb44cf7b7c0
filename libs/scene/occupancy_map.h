// The occupancy map of a scene: OctoMap (Hornung et al., OctoMap: An Efficient Probabilistic 3D Mapping Framework,
// 2013).
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <memory>
#include <vector>

#include "core/result.h"
#include "scene/estimate.h"

namespace octomap {
class OcTree;
}

namespace primo::scene {

/// An axis-aligned box in W, m.
struct Region {
  Eigen::Vector3d lower{0, 0, 0};
  Eigen::Vector3d upper{0, 0, 0};
  bool contains(const Eigen::Vector3d& p) const {
    return (p.array() >= lower.array()).all() && (p.array() <= upper.array()).all();
  }
};

/// Maximum-likelihood occupancy in an octree: every voxel is occupied, free or unknown.
class OccupancyMap {
 public:
  enum class Voxel { unknown, free, occupied };

  /// Casts a ray from its camera to each point of the clouds that lies in `region`; rays are followed inside it.
  /// @pre all points and poses are finite; resolution > 0.
  OccupancyMap(const std::vector<PointCloud>& clouds, const Region& region, double resolution);
  /// Reads to_bytes() back. Errors (data): not a complete .bt stream.
  static Result<OccupancyMap> from_bytes(const std::vector<std::uint8_t>& bytes);

  OccupancyMap(OccupancyMap&&) noexcept;
  OccupancyMap& operator=(OccupancyMap&&) noexcept;
  ~OccupancyMap();

  /// OctoMap's .bt stream. The same map has the same bytes.
  std::vector<std::uint8_t> to_bytes() const;
  Voxel at(const Eigen::Vector3d& p_W) const;
  double resolution() const;  ///< m
  /// Centres of the occupied voxels, larger leaves split to the resolution, in the order of the tree; m in W.
  std::vector<Eigen::Vector3d> occupied() const;
  const octomap::OcTree& tree() const { return *tree_; }

 private:
  explicit OccupancyMap(std::unique_ptr<octomap::OcTree> tree);
  std::unique_ptr<octomap::OcTree> tree_;
};

}  // namespace primo::scene
