// The study's work done by the graph: rollouts by planners and judges, scenes by camera and perception, rules by the
// rule learner, optimization by the optimizer.
#pragma once

#include <primo_jobs.h>

#include <memory>

#include "bus/job_client.h"
#include "common/pump.h"
#include "core/rate_limit.h"
#include "study/backend.h"

namespace primo::graph {

/// Each rollout is planned by one worker and judged by another. One thread at a time.
class DdsEvaluator : public study::Evaluator {
 public:
  static Result<std::unique_ptr<DdsEvaluator>> create(const bus::Participant& participant, bus::StatusWatcher& watcher,
                                                      Waiting waiting, const bus::ClientSettings& settings = {});
  Status evaluate(std::span<const study::Rollout> rollouts,
                  const std::function<void(std::size_t index, study::RolloutResult result)>& on_result) override;
  void cancel_all();

 private:
  using Planner = bus::JobClient<primo_msgs::msg::PlanJob, primo_msgs::msg::PlanReply>;
  using Judge = bus::JobClient<primo_msgs::msg::JudgeJob, primo_msgs::msg::JudgeReply>;
  using Deliver = std::function<void(study::RolloutResult result)>;
  explicit DdsEvaluator(Waiting waiting) : waiting_(std::move(waiting)) {}
  void plan(const study::Rollout& rollout, const Finished& finished, const Deliver& deliver);
  void judge(const study::Rollout& rollout, const motion::Plan& plan, const Finished& finished, const Deliver& deliver);

  Waiting waiting_;
  bus::Mailbox mailbox_;
  std::unique_ptr<Planner> planner_;
  std::unique_ptr<Judge> judge_;
};

/// Everything the conductor asks of others, over DDS. One thread at a time.
class DdsWorkers : public study::Workers {
 public:
  /// `map_rate` (Hz): so many scenes are observed whole and published with their occupancy map, for onlookers; of the
  /// others the cameras leave out the floor.
  static Result<std::unique_ptr<DdsWorkers>> create(const bus::Participant& participant, bus::StatusWatcher& watcher,
                                                    Waiting waiting, const bus::ClientSettings& settings,
                                                    double map_rate);

  Status evaluate(std::span<const study::Rollout> rollouts,
                  const std::function<void(std::size_t index, study::RolloutResult result)>& on_result) override {
    return evaluator_->evaluate(rollouts, on_result);
  }
  Result<std::vector<scene::SceneEstimate>> observe(std::span<const scene::Scenario> scenarios) override;
  Result<rules::RuleSet> learn(const std::string& batch, const std::vector<symbols::Experience>& experiences) override;
  Result<study::OptimizeResult> optimize(const study::OptimizeGoal& goal) override;

 private:
  using Camera = bus::JobClient<primo_msgs::msg::CameraJob, primo_msgs::msg::CameraReply>;
  using Perception = bus::JobClient<primo_msgs::msg::PerceptionJob, primo_msgs::msg::PerceptionReply>;
  DdsWorkers(const bus::Participant& participant, bus::StatusWatcher& watcher, Waiting waiting, double map_rate)
      : participant_(participant), watcher_(watcher), waiting_(std::move(waiting)), maps_(map_rate) {}
  /// Says that `role` is waited for while none of it is there.
  void say_missing(const std::string& role) const;

  bus::Participant participant_;
  bus::StatusWatcher& watcher_;
  Waiting waiting_;
  RateLimit maps_;
  bus::Mailbox mailbox_;
  std::unique_ptr<DdsEvaluator> evaluator_;
  std::unique_ptr<Camera> camera_;
  std::unique_ptr<Perception> perception_;
};

}  // namespace primo::graph
