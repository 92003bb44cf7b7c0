#include "study/generalization.h"

#include <algorithm>
#include <map>
#include <utility>

#include "core/random.h"
#include "scene/generator.h"
#include "study/causes.h"

namespace primo::study {
namespace {

/// So many scenarios of a level have streams of their own.
constexpr std::size_t kLevelStride = 1000000;

/// What is known of one primitive at one level.
struct Tried {
  Tries judged, executed;
};

/// Counts by cause; the example is the failure in the middle, by the distance at the end.
std::map<std::string, Example> failures_of(const Tries& tries, bool executed) {
  std::map<std::string, std::vector<std::pair<double, int>>> by_cause;
  for (std::size_t i = 0; i < tries.results.size(); ++i) {
    const Cause cause = cause_of(tries.results[i], executed);
    if (cause == Cause::none) continue;
    by_cause[config::enum_name(cause)].emplace_back(tries.results[i].verdict.position_error, static_cast<int>(i));
  }
  std::map<std::string, Example> failures;
  for (auto& [cause, found] : by_cause) {
    std::sort(found.begin(), found.end());
    failures[cause] = {static_cast<int>(found.size()), found[found.size() / 2].second};
  }
  return failures;
}

LevelRates rates_of(const Tried& tried) {
  LevelRates rates;
  for (const auto& result : tried.judged.results) {
    rates.final_pose.add(result.verdict.final_pose_success);
    rates.strict.add(result.verdict.success);
  }
  for (std::size_t i = 0; i < tried.executed.results.size(); ++i) {
    const bool worked = tried.executed.results[i].verdict.final_pose_success;
    rates.executed.add(worked);
    if (tried.judged.results[i].verdict.success) rates.executed_of_strict.add(worked);
  }
  rates.failures = failures_of(tried.judged, false);
  rates.not_executed = failures_of(tried.executed, true);
  return rates;
}

class Generalization {
 public:
  Generalization(const robot::Robot& robot, const Part& part, std::string id, Trials& trials)
      : robot_(robot), part_(part), settings_(part.settings.generalization), id_(std::move(id)), trials_(trials) {}

  Result<Level> run(std::size_t level, const motion::Primitive& before, const motion::Primitive& after);

 private:
  Result<Tried> try_out(std::size_t level, const std::vector<scene::Scenario>& scenarios,
                        const std::vector<scene::SceneEstimate>& estimates, const motion::Primitive& primitive);
  Result<rules::RuleSet> learn(std::size_t level, const Tries& tries, const std::string& name);
  Status learn_tables(std::size_t level, const Tried& tried, LevelRates& rates, const std::string& which);

  const robot::Robot& robot_;
  const Part& part_;
  const GeneralizationSettings& settings_;
  const std::string id_;
  Trials& trials_;
};

Result<Tried> Generalization::try_out(std::size_t level, const std::vector<scene::Scenario>& scenarios,
                                      const std::vector<scene::SceneEstimate>& estimates,
                                      const motion::Primitive& primitive) {
  Tried tried;
  for (std::size_t i = 0; i < scenarios.size(); ++i) {
    const auto add = [&](Tries& tries, physics::Mode mode) {
      tries.rollouts.push_back(held_out_rollout(part_, level, i, scenarios[i], estimates[i], primitive, mode));
    };
    add(tried.judged, physics::Mode::final_pose);
    if (i < static_cast<std::size_t>(settings_.executed)) add(tried.executed, physics::Mode::execute);
  }
  PRIMO_TRY(trials_.evaluate(tried.judged, "generalize"));
  if (!tried.executed.rollouts.empty()) PRIMO_TRY(trials_.evaluate(tried.executed, "execute"));
  return tried;
}

Result<rules::RuleSet> Generalization::learn(std::size_t level, const Tries& tries, const std::string& name) {
  std::vector<symbols::Experience> experiences;
  const std::string batch = id_ + "/level-" + std::to_string(level) + "-" + name;
  for (std::size_t i = 0; i < tries.results.size(); ++i) {
    experiences.push_back(experience_of(batch + "/" + std::to_string(i), tries.rollouts[i], tries.results[i]));
  }
  return trials_.learn(batch, experiences);
}

Status Generalization::learn_tables(std::size_t level, const Tried& tried, LevelRates& rates,
                                    const std::string& which) {
  const double d = settings_.levels[level];
  if (std::find(settings_.tables.begin(), settings_.tables.end(), d) == settings_.tables.end()) return success();
  PRIMO_ASSIGN(rates.rules, learn(level, tried.judged, which));
  if (!tried.executed.results.empty()) {
    PRIMO_ASSIGN(rates.executed_rules, learn(level, tried.executed, which + "-executed"));
  }
  return success();
}

Result<Level> Generalization::run(std::size_t level, const motion::Primitive& before, const motion::Primitive& after) {
  Level found;
  found.displacement = settings_.levels[level];
  PRIMO_ASSIGN(const Drawn drawn,
               draw_displaced(robot_, part_.training, found.displacement, settings_.seed, level * kLevelStride,
                              static_cast<std::size_t>(settings_.scenarios), "_held_out_"));
  found.rejected_touching = drawn.rejected_touching;
  found.rejected_falling = drawn.rejected_falling;
  found.rejected_in_robot = drawn.rejected_in_robot;
  PRIMO_ASSIGN(const auto estimates, trials_.observe(drawn.scenarios));
  PRIMO_ASSIGN(const Tried old_tries, try_out(level, drawn.scenarios, estimates, before));
  PRIMO_ASSIGN(const Tried new_tries, try_out(level, drawn.scenarios, estimates, after));
  found.before = rates_of(old_tries);
  found.after = rates_of(new_tries);
  PRIMO_TRY(learn_tables(level, old_tries, found.before, "P"));
  PRIMO_TRY(learn_tables(level, new_tries, found.after, "P*"));
  for (std::size_t i = 0; i < drawn.scenarios.size(); ++i) {
    const auto &p = old_tries.judged.results[i].verdict, &q = new_tries.judged.results[i].verdict;
    found.final_pose.add(p.final_pose_success, q.final_pose_success);
    found.strict.add(p.success, q.success);
  }
  for (std::size_t i = 0; i < old_tries.executed.results.size(); ++i) {
    found.executed.add(old_tries.executed.results[i].verdict.final_pose_success,
                       new_tries.executed.results[i].verdict.final_pose_success);
  }
  return found;
}

}  // namespace

Result<Drawn> draw_displaced(const robot::Robot& robot, const std::vector<scene::Scenario>& bases, double d,
                             std::uint64_t seed, std::size_t first, std::size_t count, const std::string& label) {
  Drawn all;
  for (std::size_t i = first; i < first + count; ++i) {
    const auto& base = bases[i % bases.size()];
    PRIMO_ASSIGN(auto drawn, scene::displace(robot, base, d, seed, i));
    drawn.scenario.name = base.name + label + std::to_string(i);
    all.scenarios.push_back(std::move(drawn.scenario));
    all.rejected_touching += drawn.rejected_touching;
    all.rejected_falling += drawn.rejected_falling;
    all.rejected_in_robot += drawn.rejected_in_robot;
  }
  return all;
}

Result<scene::Scenario> held_out_scenario(const robot::Robot& robot, const Part& part, std::size_t level,
                                          std::size_t index) {
  const auto& settings = part.settings.generalization;
  PRIMO_CHECK(level < settings.levels.size(), "a level of the settings");
  PRIMO_ASSIGN(auto drawn, draw_displaced(robot, part.training, settings.levels[level], settings.seed,
                                          level * kLevelStride + index, 1, "_held_out_"));
  return std::move(drawn.scenarios.front());
}

Rollout held_out_rollout(const Part& part, std::size_t level, std::size_t index, scene::Scenario scenario,
                         scene::SceneEstimate estimate, const motion::Primitive& primitive, physics::Mode mode) {
  const auto seed = Random(part.settings.generalization.seed, "held out", {level, index}).bits();
  return {std::move(scenario), std::move(estimate), primitive, seed, mode, part.settings.judge};
}

Result<std::vector<Level>> generalize(const robot::Robot& robot, const Part& part, const std::string& id,
                                      const motion::Primitive& before, const motion::Primitive& after, Trials& trials) {
  std::vector<Level> levels;
  Generalization generalization(robot, part, id, trials);
  for (std::size_t level = 0; level < part.settings.generalization.levels.size(); ++level) {
    PRIMO_ASSIGN(auto found, generalization.run(level, before, after));
    levels.push_back(std::move(found));
  }
  return levels;
}

}  // namespace primo::study
