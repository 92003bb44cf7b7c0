#include "common/dds_workers.h"

#include <primo_rules.h>
#include <primo_study.h>

#include <algorithm>
#include <atomic>
#include <optional>

#include "bus/latched.h"
#include "scene/perception.h"
#include "study/rollout.h"
#include "wire/wire.h"

namespace primo::graph {

namespace msg = primo_msgs::msg;

namespace {

template <class Client, class Topics>
Result<std::unique_ptr<Client>> make_client(const bus::Participant& participant, bus::StatusWatcher& watcher,
                                            const Topics& topics, bus::Mailbox& mailbox, const Waiting& waiting,
                                            const bus::ClientSettings& settings) {
  PRIMO_ASSIGN(auto client, Client::create(participant, watcher, topics, mailbox, settings));
  client.on_waiting(waiting.waiting_for);
  return std::make_unique<Client>(std::move(client));
}

/// What the action is about must have been seen.
Status require_arguments(const scene::Scenario& scenario, const scene::SceneEstimate& estimate) {
  std::vector<std::string> names;
  for (std::size_t i = 1; i < scenario.action.size(); ++i) {
    if (scenario.object(scenario.action[i]) != nullptr) names.push_back(scenario.action[i]);
  }
  return scene::require_objects(estimate, names);
}

/// Enough that no worker runs dry while its next job is being prepared.
std::size_t jobs_under_way(unsigned windows) { return std::max<std::size_t>(4, 2 * static_cast<std::size_t>(windows)); }

}  // namespace

Result<std::unique_ptr<DdsEvaluator>> DdsEvaluator::create(const bus::Participant& participant,
                                                           bus::StatusWatcher& watcher, Waiting waiting,
                                                           const bus::ClientSettings& settings) {
  std::unique_ptr<DdsEvaluator> evaluator(new DdsEvaluator(std::move(waiting)));
  PRIMO_ASSIGN(evaluator->planner_, make_client<Planner>(participant, watcher, topics::kPlan, evaluator->mailbox_,
                                                         evaluator->waiting_, settings));
  PRIMO_ASSIGN(evaluator->judge_, make_client<Judge>(participant, watcher, topics::kJudge, evaluator->mailbox_,
                                                     evaluator->waiting_, settings));
  return evaluator;
}

Status DdsEvaluator::evaluate(std::span<const study::Rollout> rollouts,
                              const std::function<void(std::size_t, study::RolloutResult)>& on_result) {
  const auto window = [this] { return jobs_under_way(planner_->window() + judge_->window()); };
  const auto start = [&](std::size_t index, const Finished& finished) {
    plan(rollouts[index], finished,
         [&on_result, index](study::RolloutResult result) { on_result(index, std::move(result)); });
  };
  return pump(mailbox_, waiting_, rollouts.size(), window, start, [this] { cancel_all(); });
}

void DdsEvaluator::plan(const study::Rollout& rollout, const Finished& finished, const Deliver& deliver) {
  msg::PlanJob job;
  job.request(wire::to_wire(study::plan_request(rollout)));
  const auto submitted =
      planner_->submit(std::move(job), [this, &rollout, finished, deliver](Result<msg::PlanReply> reply) {
        if (!finished.active()) return;
        if (!reply.ok()) return finished(reply.error().at("planning " + rollout.scenario.name));
        const auto plan = wire::from_wire(reply->plan());
        if (!plan.ok()) return finished(plan.error().at("the plan from " + reply->reply().worker()));
        if (study::has_trajectory(*plan)) return judge(rollout, *plan, finished, deliver);
        deliver(study::rollout_without_plan(*plan));
        finished(success());
      });
  if (!submitted.ok()) finished(submitted.error());
}

void DdsEvaluator::judge(const study::Rollout& rollout, const motion::Plan& plan, const Finished& finished,
                         const Deliver& deliver) {
  msg::JudgeJob job;
  job.request(wire::to_wire(study::judge_request(rollout, plan)));
  // Of the plan only this much is kept until the verdict comes.
  motion::Plan head = plan;
  head.trajectory = {};
  head.gains = {};
  const auto submitted = judge_->submit(
      std::move(job), [&rollout, head = std::move(head), finished, deliver](Result<msg::JudgeReply> reply) {
        if (!finished.active()) return;
        if (!reply.ok()) return finished(reply.error().at("judging " + rollout.scenario.name));
        auto verdict = wire::from_wire(reply->verdict());
        if (!verdict.ok()) return finished(verdict.error().at("the verdict from " + reply->reply().worker()));
        deliver(study::rollout_result(head, std::move(verdict).value()));
        finished(success());
      });
  if (!submitted.ok()) finished(submitted.error());
}

void DdsEvaluator::cancel_all() {
  planner_->cancel_all();
  judge_->cancel_all();
}

Result<std::unique_ptr<DdsWorkers>> DdsWorkers::create(const bus::Participant& participant, bus::StatusWatcher& watcher,
                                                       Waiting waiting, const bus::ClientSettings& settings,
                                                       double map_rate) {
  std::unique_ptr<DdsWorkers> workers(new DdsWorkers(participant, watcher, std::move(waiting), map_rate));
  PRIMO_ASSIGN(workers->evaluator_, DdsEvaluator::create(participant, watcher, workers->waiting_, settings));
  PRIMO_ASSIGN(workers->camera_, make_client<Camera>(participant, watcher, topics::kCamera, workers->mailbox_,
                                                     workers->waiting_, settings));
  PRIMO_ASSIGN(workers->perception_, make_client<Perception>(participant, watcher, topics::kPerception,
                                                             workers->mailbox_, workers->waiting_, settings));
  return workers;
}

Result<std::vector<scene::SceneEstimate>> DdsWorkers::observe(std::span<const scene::Scenario> scenarios) {
  std::vector<scene::SceneEstimate> estimates(scenarios.size());
  const auto start = [&](std::size_t index, const Finished& finished) {
    msg::CameraJob look;
    look.scenario(wire::to_wire(scenarios[index]));
    const bool whole = maps_.due();
    if (!whole) look.lowest(scene::lowest_of_interest(scenarios[index]));
    const auto seen = [this, &scenarios, &estimates, index, finished, whole](Result<msg::CameraReply> clouds) {
      if (!finished.active()) return;
      const std::string place = "observing " + scenarios[index].name;
      if (!clouds.ok()) return finished(clouds.error().at(place));
      msg::PerceptionJob job;
      job.scenario(wire::to_wire(scenarios[index]));
      job.clouds(std::move(clouds->clouds()));
      job.octree(whole);
      const auto perceived = [&scenarios, &estimates, index, finished, place](Result<msg::PerceptionReply> reply) {
        if (!finished.active()) return;
        if (!reply.ok()) return finished(reply.error().at(place));
        auto estimate = wire::from_wire(reply->estimate());
        if (!estimate.ok()) return finished(estimate.error().at("the scene from " + reply->reply().worker()));
        if (const auto found = require_arguments(scenarios[index], *estimate); !found.ok()) {
          return finished(found.error().at(place));
        }
        estimates[index] = std::move(estimate).value();
        estimates[index].octree.clear();  // it was for onlookers
        finished(success());
      };
      const auto submitted = perception_->submit(std::move(job), perceived);
      if (!submitted.ok()) finished(submitted.error());
    };
    const auto submitted = camera_->submit(std::move(look), seen);
    if (!submitted.ok()) finished(submitted.error());
  };
  const auto window = [this] { return jobs_under_way(camera_->window() + perception_->window()); };
  const auto cancel = [this] {
    camera_->cancel_all();
    perception_->cancel_all();
  };
  PRIMO_TRY(pump(mailbox_, waiting_, scenarios.size(), window, start, cancel));
  return estimates;
}

void DdsWorkers::say_missing(const std::string& role) const {
  waiting_.waiting_for(watcher_.workers(role).empty() ? "a " + role + "; none is up" : "");
}

Result<rules::RuleSet> DdsWorkers::learn(const std::string& batch,
                                         const std::vector<symbols::Experience>& experiences) {
  std::vector<std::string> ids;
  for (const auto& experience : experiences) ids.push_back(experience.id);
  const std::string digest = wire::experience_digest(ids);

  // The answer is latched by the learner, the experiences by us: whoever of the two starts again finds what it needs.
  const auto answer = std::make_shared<std::optional<msg::RuleSet>>();
  const auto on_rules = [this, answer, batch, digest](msg::RuleSet&& rules) {
    if (rules.batch() != batch || rules.digest() != digest) return;
    mailbox_.post([answer, rules = std::move(rules)] { *answer = rules; });
  };
  PRIMO_ASSIGN(const auto subscription,
               bus::Subscription<msg::RuleSet>::create(participant_, topics::kRuleSet, on_rules));
  PRIMO_ASSIGN(auto publisher, bus::Publisher<msg::Experience>::create(participant_, topics::kExperience));
  for (const auto& experience : experiences) PRIMO_TRY(publisher.publish(wire::to_wire(experience, batch)));

  const auto status = run_until(mailbox_, waiting_, [&] {
    say_missing("rule_learner");
    return answer->has_value();
  });
  waiting_.waiting_for("");
  PRIMO_TRY(status);
  return wire::from_wire(**answer);
}

Result<study::OptimizeResult> DdsWorkers::optimize(const study::OptimizeGoal& goal) {
  msg::OptimizeGoal message = wire::to_wire(goal);
  // An answer latched from before this call must not count, whoever asked for it. This process may run many studies.
  static std::atomic<int> requests{0};
  message.request(participant_.id() + "-" + std::to_string(++requests));
  const auto answer = std::make_shared<std::optional<msg::OptimizedPrimitive>>();
  const auto on_primitive = [this, answer, request = message.request()](msg::OptimizedPrimitive&& primitive) {
    if (primitive.request() != request) return;
    mailbox_.post([answer, primitive = std::move(primitive)] { *answer = primitive; });
  };
  PRIMO_ASSIGN(const auto subscription,
               bus::Subscription<msg::OptimizedPrimitive>::create(participant_, topics::kPrimitive, on_primitive));
  PRIMO_ASSIGN(auto publisher, bus::Publisher<msg::OptimizeGoal>::create(participant_, topics::kOptimizeGoal));
  PRIMO_TRY(publisher.publish(message));

  const auto status = run_until(mailbox_, waiting_, [&] {
    say_missing("optimizer");
    return answer->has_value();
  });
  waiting_.waiting_for("");
  if (!status.ok()) {
    // Nobody waits for it any more.
    message.request("");
    PRIMO_TRY(publisher.publish(message));
    publisher.wait_acknowledged(std::chrono::milliseconds(200));
    return status.error();
  }
  return wire::from_wire(**answer);
}

}  // namespace primo::graph
