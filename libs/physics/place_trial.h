// The final pose of a place in physics: the hand alone, where the plan ends, with the held object between its fingers,
// above the true scene. It opens, retreats along its approach, and what it let go comes to rest.
#pragma once

#include <map>
#include <memory>
#include <mutex>
#include <optional>

#include "physics/bystanders.h"
#include "physics/execution.h"
#include "physics/hand_model.h"
#include "physics/place_end.h"

namespace primo::physics {

/// A scene's model with the hand on a slide along its approach, and scratch data: for one thread at a time. A trial
/// sets everything it reads.
struct PlaceWorkspace {
  Model model;
  Data data;
  JointMap joints;
  PlaceBodies bodies;
  int hand_body = -1, slide = -1;
  Pin pin;  ///< of the held object
  Bystanders bystanders;

  /// Poses of the scenario's objects are not part of it. Errors: what MuJoCo refuses.
  static Result<PlaceWorkspace> create(const robot::Robot& robot, const HandMjcf& hand, const scene::Scenario& scenario,
                                       double timestep);
};

/// Places of one robot, in any number of threads at once.
class PlaceTrials {
 public:
  explicit PlaceTrials(const robot::Robot& robot) : robot_(robot) {}

  /// q: the final configuration, its fingers as they hold the object. The trial's X_PO is the object's pose in the hand
  /// when it lets go. Error: a model that MuJoCo refuses. @pre the request is valid (see Judge).
  Result<Execution> run(const JudgeRequest& request, const Eigen::VectorXd& q);

 private:
  Result<std::unique_ptr<PlaceWorkspace>> take(const std::string& key, const JudgeRequest& request);
  void give_back(const std::string& key, std::unique_ptr<PlaceWorkspace> workspace);

  const robot::Robot& robot_;
  std::mutex mutex_;
  std::optional<HandMjcf> hand_;
  std::map<std::string, std::vector<std::unique_ptr<PlaceWorkspace>>> pool_;
  std::size_t pooled_ = 0;
};

}  // namespace primo::physics
