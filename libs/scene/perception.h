// From depth images to a scene: the table, the objects on it and the occupancy map behind them.
//
// The robot and the floor are no part of it: the robot is filtered out by the camera, the floor lies below the table
// range. Objects are upright cylinders and upright boxes that stand on the table; cylinders that lie are fitted as
// boxes.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "core/result.h"
#include "scene/estimate.h"
#include "scene/scenario.h"

namespace primo::scene {

struct PerceptionSettings {
  double resolution = 0.02;          ///< m, of the octree
  double min_table_height = 0.15;    ///< m, lower planes are floor
  double max_table_height = 1.6;     ///< m
  double min_object_height = 0.015;  ///< m, lower things are table
  double above_table = 0.008;        ///< m, points lower than this over the table are table: 5 σ of the depth noise
  double cluster_gap = 0.008;        ///< m, edge of the voxels whose neighbours (26) belong to one cluster
  int min_points = 40;               ///< an object has at least so many points
  double max_residual = 0.0015;      ///< m rms; clusters that fit one shape worse than this are split
  double match_distance = 0.1;       ///< m in the plane, between a label and the object that gets its name
  template <class V>
  void visit(V&& v) {
    v("resolution", resolution, {.help = "of the octree", .unit = "m", .min = 0.004, .max = 0.2});
    v("min_table_height", min_table_height, {.help = "lower planes are floor", .unit = "m", .min = 0.01, .max = 3});
    v("max_table_height", max_table_height, {.help = "higher planes are no table", .unit = "m", .min = 0.02, .max = 5});
    v("min_object_height", min_object_height, {.help = "lower things are table", .unit = "m", .min = 0.002, .max = 1});
    v("above_table", above_table,
      {.help = "points lower than this over the table are table", .unit = "m", .min = 0.001, .max = 0.1});
    v("cluster_gap", cluster_gap, {.help = "edge of the clustering voxels", .unit = "m", .min = 0.002, .max = 0.1});
    v("min_points", min_points, {.help = "of an object", .min = 10, .max = 100000});
    v("max_residual", max_residual,
      {.help = "rms to one shape; worse clusters are split", .unit = "m", .min = 1e-4, .max = 0.1});
    v("match_distance", match_distance,
      {.help = "between a label and the object that gets its name", .unit = "m", .min = 0, .max = 1});
  }
};

/// A name and roughly where its bearer stands. It only decides which found object gets the name.
struct Label {
  std::string name;
  Eigen::Vector3d position{0, 0, 0};  ///< m in W
};

struct PerceptionRequest {
  std::string scene;               ///< scene_id of the clouds' scenario; empty on a live camera
  std::vector<PointCloud> clouds;  ///< with camera poses
  std::vector<Label> labels;       ///< none: all objects are named o1, o2, …
  std::string table = "table";     ///< the table's name in the answer
  PerceptionSettings settings;
  /// What the hand holds: known from the hand, as cameras filter it out together with the robot. Goes into the answer
  /// as it is.
  std::optional<ObjectEstimate> held = {};
  bool octree = true;  ///< whether the answer has the octree; it is most of the time that perception takes
  double lowest = 0;   ///< m in W; table and objects are looked for among points that are not lower
};

/// The labels of a scenario's objects that are not in the hand.
std::vector<Label> labels_of(const Scenario& scenario);

/// m in W: the table and what stands on it are higher; 0 for a table on the floor. Perception needs no point that is
/// lower, and these are most of a picture.
double lowest_of_interest(const Scenario& scenario);

/// What is seen in clouds of this scenario: scene id, labels and the held object from it.
PerceptionRequest perception_request(const Scenario& scenario, std::vector<PointCloud> clouds,
                                     const PerceptionSettings& settings = {});

/// A pure function: same request, same bytes. Errors (data): no points, points or poses that are not finite, sizes out
/// of range; (failed): no table was seen. Objects that were not found are missing in the answer, see require_objects().
Result<SceneEstimate> perceive(const PerceptionRequest& request);
Result<SceneEstimate> perceive(const std::vector<PointCloud>& clouds, const PerceptionSettings& settings = {});

/// The error that names what was not found: "object c1 was not found in the points: found c2, o1".
Status require_objects(const SceneEstimate& estimate, const std::vector<std::string>& names);

}  // namespace primo::scene
