#include "study/scenario_selection.h"

#include <cstdio>
#include <string>
#include <utility>

#include "core/hash.h"

namespace primo::study {
namespace {

/// The scene itself, then its displaced copies.
Result<std::vector<scene::Scenario>> variants(const SelectionSettings& settings, const robot::Robot& robot,
                                              const scene::Scenario& scenario) {
  std::vector<scene::Scenario> all = {scenario};
  for (int i = 0; i < settings.displaced; ++i) {
    PRIMO_ASSIGN(auto displaced,
                 scene::displace(robot, scenario, settings.displacement, settings.seed, static_cast<std::uint64_t>(i)));
    all.push_back(std::move(displaced.scenario));
  }
  return all;
}

std::vector<Rollout> rollouts(const SelectionSettings& settings, const std::vector<scene::Scenario>& scenarios,
                              const std::vector<scene::SceneEstimate>& estimates, const motion::Primitive& primitive) {
  std::vector<Rollout> all;
  for (std::size_t i = 0; i < scenarios.size(); ++i) {
    Rollout rollout;
    rollout.scenario = scenarios[i];
    rollout.estimate = estimates[i];
    rollout.primitive = primitive;
    rollout.judge_seed = Hasher().add("selection").add(settings.seed).add(i).value();
    rollout.judge = settings.judge;
    all.push_back(std::move(rollout));
  }
  return all;
}

struct Tried {
  Rate rate;
  bool itself = false;  ///< success in the scene itself
};

Result<Tried> attempt(const std::vector<Rollout>& rollouts, Evaluator& evaluator) {
  Tried tried;
  PRIMO_TRY(evaluator.evaluate(rollouts, [&](std::size_t index, const RolloutResult& result) {
    tried.rate.add(result.verdict.success);
    if (index == 0) tried.itself = result.verdict.success;
  }));
  return tried;
}

}  // namespace

Result<std::vector<SelectedScenario>> select_difficult(const SelectionSettings& settings, const robot::Robot& robot,
                                                       const SceneSource& scene, const motion::Primitive& hand_tuned,
                                                       const motion::Primitive& reference, Workers& workers,
                                                       const std::function<void(const SelectedScenario&)>& on_tried) {
  std::vector<SelectedScenario> tried;
  int chosen = 0;
  for (int index = 0; index < settings.pool && chosen < settings.count; ++index) {
    SelectedScenario one;
    one.index = index;
    PRIMO_ASSIGN(one.scenario, scene(static_cast<std::uint64_t>(index)));
    PRIMO_ASSIGN(const auto scenarios, variants(settings, robot, one.scenario));
    PRIMO_ASSIGN(const auto estimates, workers.observe(scenarios));
    PRIMO_ASSIGN(const auto by_hand, attempt(rollouts(settings, scenarios, estimates, hand_tuned), workers));
    one.hand_tuned = by_hand.rate;
    if (one.hand_tuned.value() <= settings.difficult_below) {
      PRIMO_ASSIGN(const auto by_reference, attempt(rollouts(settings, scenarios, estimates, reference), workers));
      one.reference = by_reference.rate;
      one.chosen = by_reference.itself && one.reference.value() >= settings.feasible_from;
    }
    chosen += one.chosen;
    if (on_tried) on_tried(one);
    tried.push_back(std::move(one));
  }
  if (chosen < settings.count) {
    return Error{Code::failed, "only " + std::to_string(chosen) + " of " + std::to_string(settings.count) +
                                   " scenarios found in a pool of " + std::to_string(settings.pool) +
                                   " random scenes; enlarge the pool or relax the thresholds"};
  }
  return tried;
}

}  // namespace primo::study
