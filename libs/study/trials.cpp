#include "study/trials.h"

#include <algorithm>
#include <utility>

#include "study/codec.h"

namespace primo::study {
namespace {

/// How many scenes are asked for at once: so much work at most is done again after a kill.
constexpr std::size_t kObserveBatch = 32;

double seconds_since(std::chrono::steady_clock::time_point begin) {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
}

}  // namespace

void Trials::progress(const std::string& stage, int done, int total, const Rate& success, bool finished,
                      const std::string& text) const {
  if (!on_progress_) return;
  Progress progress = heading_;
  progress.stage = stage;
  progress.done = done;
  progress.total = total;
  progress.success = success;
  progress.finished = finished;
  progress.text = text;
  on_progress_(progress);
}

Result<std::vector<scene::SceneEstimate>> Trials::observe(const std::vector<scene::Scenario>& scenarios) {
  std::vector<scene::SceneEstimate> estimates(scenarios.size());
  std::vector<std::size_t> missing;
  for (std::size_t i = 0; i < scenarios.size(); ++i) {
    PRIMO_ASSIGN(const auto reply, journal_.find(key_of(scenarios[i])));
    if (!reply) {
      missing.push_back(i);
      continue;
    }
    PRIMO_ASSIGN(estimates[i], decode_estimate(*reply));
  }
  for (std::size_t begin = 0; begin < missing.size(); begin += kObserveBatch) {
    const std::size_t end = std::min(missing.size(), begin + kObserveBatch);
    std::vector<scene::Scenario> batch;
    for (std::size_t m = begin; m < end; ++m) batch.push_back(scenarios[missing[m]]);
    const auto asked_at = Clock::now();
    PRIMO_ASSIGN(const auto seen, workers_.observe(batch));
    PRIMO_CHECK(seen.size() == batch.size(), "observe() answers for each scenario");
    const double seconds = seconds_since(asked_at) / static_cast<double>(batch.size());
    std::vector<Answer> answers;
    for (std::size_t b = 0; b < batch.size(); ++b)
      answers.push_back({key_of(batch[b]), "observe", encode(seen[b]), seconds});
    PRIMO_ASSIGN(const auto replies, journal_.record(answers));
    for (std::size_t b = 0; b < batch.size(); ++b) {
      PRIMO_ASSIGN(estimates[missing[begin + b]], decode_estimate(replies[b]));
    }
    progress("observe", static_cast<int>(scenarios.size() - missing.size() + end), static_cast<int>(scenarios.size()),
             {}, end == missing.size());
  }
  return estimates;
}

Status Trials::evaluate(Tries& tries, const std::string& stage_name) {
  tries.results.assign(tries.rollouts.size(), {});
  Rate so_far;
  std::string refused;
  const int total = static_cast<int>(tries.rollouts.size());
  PRIMO_TRY(evaluator_.evaluate(tries.rollouts, [&](std::size_t i, RolloutResult result) {
    if (result.plan_status == motion::PlanStatus::bad_input)
      refused = tries.rollouts[i].scenario.name + ": " + result.plan_reason;
    const bool executed = tries.rollouts[i].mode == physics::Mode::execute;
    so_far.add(executed ? result.verdict.final_pose_success : result.verdict.success);
    tries.results[i] = std::move(result);
    if (so_far.trials % 10 == 0 || so_far.trials == total) {
      progress(stage_name, static_cast<int>(so_far.trials), total, so_far, so_far.trials == total,
               tries.rollouts[i].primitive.name);
    }
  }));
  if (!refused.empty()) return Error{Code::failed, "the planner refused a request of the study: " + refused};
  return success();
}

Result<rules::RuleSet> Trials::learn(const std::string& batch, const std::vector<symbols::Experience>& experiences) {
  const std::string key = key_of(experiences);
  PRIMO_ASSIGN(auto reply, journal_.find(key));
  if (!reply) {
    const auto asked_at = Clock::now();
    PRIMO_ASSIGN(const auto learned, workers_.learn(batch + "-" + key.substr(0, 8), experiences));
    const Answer answer{key, "learn", rules::to_json(learned), seconds_since(asked_at)};
    PRIMO_ASSIGN(const auto replies, journal_.record({&answer, 1}));
    reply = replies.front();
  }
  progress("learn", static_cast<int>(experiences.size()), static_cast<int>(experiences.size()), {}, true);
  return rules::rules_from_json(*reply);
}

Result<OptimizeResult> Trials::optimize(const OptimizeGoal& goal) {
  const std::string key = key_of(goal);
  PRIMO_ASSIGN(auto reply, journal_.find(key));
  if (!reply) {
    const auto asked_at = Clock::now();
    PRIMO_ASSIGN(const auto found, workers_.optimize(goal));
    const Answer answer{key, "optimize", encode(found), seconds_since(asked_at)};
    PRIMO_ASSIGN(const auto replies, journal_.record({&answer, 1}));
    reply = replies.front();
  }
  return decode_optimize_result(*reply);
}

symbols::Experience experience_of(const std::string& id, const Rollout& rollout, const RolloutResult& result) {
  const auto& action = rollout.scenario.action;
  symbols::Experience experience;
  experience.id = id;
  experience.objects = result.verdict.objects;
  experience.before = result.verdict.before;
  experience.action = {action.front(), {action.begin() + 1, action.end()}, false};
  experience.after = result.verdict.after;
  return experience;
}

}  // namespace primo::study
