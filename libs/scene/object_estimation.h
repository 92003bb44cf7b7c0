// The table and the objects on it, from points.
#pragma once

#include <vector>

#include "core/result.h"
#include "scene/estimate.h"
#include "scene/perception.h"
#include "scene/shape_fit.h"

namespace primo::scene {

struct TableFit {
  Table table;     ///< its thickness is not seen: the default
  double rms = 0;  ///< m, of the points on it: the depth noise along z
  int points = 0;
};

/// m: points farther from a plane than this do not change what estimate_table() makes of it.
inline constexpr double kTableReach = 0.12;

/// The level plane with the most points between the heights of the settings, and the extent of its points along x and
/// y.
Result<TableFit> estimate_table(const Points& points, const PerceptionSettings& settings);

/// Groups of points that are connected through neighbouring voxels (26 neighbours) of edge `voxel`, each of at least
/// `min_points`; in the order of their lowest voxel.
std::vector<Points> clusters(const Points& points, double voxel, int min_points);

/// Shapes of the things that stand on the table. A cluster that no single shape fits is split among two to five that
/// do.
std::vector<ObjectEstimate> estimate_objects(const Points& points, const TableFit& table,
                                             const PerceptionSettings& settings);

}  // namespace primo::scene
