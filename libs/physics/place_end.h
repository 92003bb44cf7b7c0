// What became of an object that was to be placed: measures, criteria, and the graded score of a place.
#pragma once

#include <string>
#include <vector>

#include "physics/joint_map.h"
#include "physics/verdict.h"

namespace primo::physics {

/// One body over another, from their shapes and poses.
struct Stacking {
  double offset = 0;   ///< m, horizontal, between the centres; over a table: how far the centre is beyond its edge
  double height = 0;   ///< m, of the centres' vertical displacement over the sum of both half heights
  double tilt = 0;     ///< rad, of X's axis from the vertical, either way up
  double overlap = 0;  ///< m, how deep X is in its support, 0 when apart
};
Stacking stacking(const scene::Scenario& scenario, const Pose& X_WX, const Pose& X_WY);

/// Where the support is in the scenario; of a table, its centre.
Pose support_pose(const scene::Scenario& scenario);

/// How a place ended. Contacts count over the last 50 ms.
struct PlaceEnd {
  Stacking planned;         ///< at the end of the motion, before the hand opens
  Stacking found;           ///< at the end
  double speed = 0;         ///< m/s, of the fastest point of X
  double support_tilt = 0;  ///< rad, of the support from how it stood
  bool touches_support = false;
  bool touches_hand = false;
};

/// The ids of X and its support in a model assembled by assemble(). A table is a geom of the world.
struct PlaceBodies {
  int object_body = -1, object_geom = -1, support_body = 0, support_geom = -1;
  PlaceBodies() = default;
  PlaceBodies(const Model& model, const scene::Scenario& scenario);
};

/// Watches X while it comes to rest.
class PlaceObserver {
 public:
  PlaceObserver(const scene::Scenario& scenario, const JointMap& joints, const PlaceBodies& bodies)
      : scenario_(scenario), joints_(joints), bodies_(bodies) {}
  /// Notes the contacts of one step within the window at the end.
  void note_contacts(const mjModel* model, const mjData* data);
  void forget_contacts();
  /// m/s, of the fastest point of X or its support.
  double speed(const mjModel* model, const mjData* data) const;
  /// @pre positions are up to date (mj_forward).
  PlaceEnd end(const mjModel* model, const mjData* data) const;

 private:
  const scene::Scenario& scenario_;
  const JointMap& joints_;
  PlaceBodies bodies_;
  bool touches_support_ = false, touches_hand_ = false;
};

/// The criteria of a place, each with value and margin: place_height, place_offset, place_tilt, place_speed,
/// place_on_support and place_off_hand; then `on` (all of them, and the support stands) and `on_paper`.
std::vector<Criterion> place_criteria(const PlaceEnd& end, const JudgeSettings& settings);

struct PlaceDecision {
  Outcome outcome = Outcome::not_on;
  std::string reason;
  double score = 0;
};
/// By the criterion that the settings choose. The score: 0.8 + 0.2 (1 − offset/limit) when placed; else at most 0.7,
/// smooth in the planned offset, height, tilt and overlap.
PlaceDecision decide_place(const PlaceEnd& end, const JudgeSettings& settings);

/// s of a place that ends away from its support, overlapping it by more than the limit or not on it.
double place_score(const Stacking& planned, const JudgeSettings& settings);

/// When the hand lets go: s since the fingers begin to open, and what follows.
inline constexpr double kOpenSeconds = 0.3, kRetreatSeconds = 0.5, kRestSeconds = 0.6;
inline constexpr double kRetreat = 0.15;         ///< m, back along the approach
inline constexpr double kContactSeconds = 0.05;  ///< at the end, in which contacts count

/// The fingers' servo targets while they open, from those that hold to the robot's home; joints that do not close stay.
Eigen::VectorXd opening_targets(const robot::Robot& robot, const Eigen::VectorXd& holding, double seconds);

}  // namespace primo::physics
