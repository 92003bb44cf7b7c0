// All of a study's work in this process, on a few threads. What the services do over DDS, with the same functions.
#pragma once

#include <filesystem>
#include <functional>
#include <memory>

#include "physics/judge.h"
#include "robot/robot.h"
#include "study/backend.h"
#include "study/optimization.h"

namespace primo::study {

struct LocalOptions {
  int threads = 0;                 ///< 0: as many as there are processors
  std::function<bool()> stopping;  ///< asked between jobs; true ends the work with Code::unavailable
  OnProgress on_progress;          ///< of the optimization
};

class LocalWorkers : public Workers {
 public:
  /// Errors: the robot file or its model cannot be used.
  static Result<std::unique_ptr<LocalWorkers>> create(const std::filesystem::path& robot_file,
                                                      LocalOptions options = {});

  Result<RolloutResult> roll_out(const Rollout& rollout) const;
  /// The same with the plan of its request in hand.
  Result<RolloutResult> judge(const Rollout& rollout, const motion::Plan& plan) const;
  const robot::Robot& robot() const { return robot_; }

  Status evaluate(std::span<const Rollout> rollouts,
                  const std::function<void(std::size_t index, RolloutResult result)>& on_result) override;
  Result<std::vector<scene::SceneEstimate>> observe(std::span<const scene::Scenario> scenarios) override;
  Result<rules::RuleSet> learn(const std::string& batch, const std::vector<symbols::Experience>& experiences) override;
  Result<OptimizeResult> optimize(const OptimizeGoal& goal) override;

 private:
  LocalWorkers(robot::Robot robot, LocalOptions options);
  robot::Robot robot_;
  physics::Judge judge_;
  LocalOptions options_;
};

/// Camera and perception of one scenario, in this process. Error (failed): an argument of its action was not found in
/// the points.
Result<scene::SceneEstimate> observe_scenario(const scene::Scenario& scenario);

}  // namespace primo::study
