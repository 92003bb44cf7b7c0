// The paper's grasp test: close the hand on the held object, let go, shake. Hand and object only, in the hand's frame.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "physics/hand_model.h"
#include "physics/joint_map.h"
#include "physics/verdict.h"

namespace primo::physics {

/// A hand model with its scratch data: for one thread at a time. A trial sets everything it reads, so what ran before
/// does not matter.
struct HandWorkspace {
  Model model;
  Data data;
  JointMap joints;
  Eigen::Vector3d centre{0, 0, 0};  ///< the grasp centre in P, m: what the jiggle turns about
  int object_body = -1, object_geom = -1, object_joint = -1;
  Pin pin;  ///< of the object

  static Result<HandWorkspace> create(const robot::Robot& robot, const mjModel* whole, const Shape& object, double mass,
                                      double timestep);
};

struct TrialResult {
  Outcome outcome = Outcome::unstable;
  std::string reason;
  double score = 0;         ///< s of the graded fitness, in [0, 1]
  double displacement = 0;  ///< m, largest since the release, in the hand's frame
  double survival = 0;      ///< fraction of the jiggle
  int steps = 0;
  Pose X_PO = Pose::Identity();     ///< of the object at the end
  std::vector<Criterion> criteria;  ///< the action's own, beside those of the path
};

/// q: the final configuration, all joints; X_WP: the hand's frame there; X_WO: the object; position_error: m, grades a
/// miss.
/// @pre the workspace is of this robot and object.
TrialResult run_trial(const robot::Robot& robot, HandWorkspace& workspace, const Eigen::VectorXd& q, const Pose& X_WP,
                      const Pose& X_WO, double position_error, const JudgeSettings& settings, std::uint64_t seed);

/// " at step 12 (0.024 s)": where a simulation diverged.
std::string unstable_at(int steps, double timestep);

/// s of a hand that misses the object, and of one that starts inside it by more than the limit (penetration, limit: m).
double miss_score(double position_error);
double penetration_score(double position_error, double penetration, double limit);

}  // namespace primo::physics
