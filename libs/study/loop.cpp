#include "study/loop.h"

#include <algorithm>
#include <cstdio>
#include <iterator>
#include <optional>
#include <utility>

#include "core/files.h"
#include "core/random.h"
#include "rules/learner.h"
#include "rules/prediction.h"
#include "study/fitness.h"
#include "study/generalization.h"
#include "study/trials.h"
#include "symbols/literal_json.h"

namespace primo::study {
namespace {

namespace fs = std::filesystem;
using symbols::Literal;

std::string padded(std::size_t i) {
  char text[24];
  std::snprintf(text, sizeof text, "%05zu", i);
  return text;
}

/// The loop of one part.
class Loop {
 public:
  Loop(const std::string& id, const robot::Robot& robot, const Part& part, const fs::path& directory, Workers& workers,
       Journal& journal, const OnProgress& on_progress)
      : id_(id),
        robot_(robot),
        part_(part),
        directory_(directory),
        trials_(workers, journal, on_progress, heading(id, part)) {}

  Result<PartResult> run();

 private:
  static Progress heading(const std::string& id, const Part& part) {
    Progress progress;
    progress.study = id;
    progress.part = part.name;
    return progress;
  }
  Tries training_tries(const motion::Primitive& primitive) const;
  Tries displaced_tries(const motion::Primitive& primitive, physics::Mode mode, std::size_t count) const;
  Rates rates(const Tries& tries, const std::vector<Literal>& desired) const;
  Result<std::vector<symbols::Experience>> experiences(std::size_t collection, const Tries& tries) const;
  Result<std::vector<Literal>> desired_outcome(const rules::RuleSet& rules) const;
  /// Tries the primitive everywhere and learns from it. Without a desired outcome yet, it becomes that of the rules
  /// learned here.
  Result<Collection> collect(const motion::Primitive& primitive, std::vector<Literal>& desired);
  OptimizeGoal goal(const motion::Primitive& primitive, const std::vector<Literal>& desired) const;
  Status observe();
  Status improve(PartResult& result);
  Status execute(Collection& collection);

  const std::string& id_;
  const robot::Robot& robot_;
  const Part& part_;
  const fs::path& directory_;
  Trials trials_;
  std::size_t collections_ = 0;
  std::vector<scene::Scenario> displaced_;
  std::vector<scene::SceneEstimate> training_estimates_, displaced_estimates_;
  std::vector<scene::Scenario> pool_;  // robust protocol: what generations draw from, then what the choice is made on
  std::vector<scene::SceneEstimate> pool_estimates_;
};

Tries Loop::training_tries(const motion::Primitive& primitive) const {
  Tries tries;
  for (int repetition = 0; repetition < part_.settings.optimizer.settings.validation; ++repetition) {
    for (std::size_t k = 0; k < part_.training.size(); ++k) {
      tries.rollouts.push_back({part_.training[k], training_estimates_[k], primitive,
                                validation_seed(part_.settings.seed, repetition, k), physics::Mode::final_pose,
                                part_.settings.judge});
    }
  }
  return tries;
}

Tries Loop::displaced_tries(const motion::Primitive& primitive, physics::Mode mode, std::size_t count) const {
  Tries tries;
  for (std::size_t i = 0; i < std::min(count, displaced_.size()); ++i) {
    const auto seed = Random(part_.settings.experience.seed, "experience", {i}).bits();
    tries.rollouts.push_back({displaced_[i], displaced_estimates_[i], primitive, seed, mode, part_.settings.judge});
  }
  return tries;
}

/// By which criteria a placed object is on its support; empty where nothing was placed.
std::string on_by(const physics::Verdict& verdict) {
  const auto met = [&](const char* name) -> std::optional<bool> {
    for (const auto& criterion : verdict.criteria) {
      if (criterion.name == name) return criterion.met;
    }
    return std::nullopt;
  };
  const auto full = met("on"), paper = met("on_paper");
  if (!full || !paper) return {};
  if (*full) return *paper ? "both" : "full only";
  return *paper ? "paper only" : "neither";
}

Rates Loop::rates(const Tries& tries, const std::vector<Literal>& desired) const {
  Rates rates;
  for (std::size_t i = 0; i < tries.results.size(); ++i) {
    const RolloutResult& result = tries.results[i];
    const bool success = succeeded(result, desired, tries.rollouts[i].scenario.action);
    rates.final_pose.add(result.verdict.final_pose_success);
    rates.strict.add(result.verdict.success);
    rates.desired.add(success);
    rates.gamma += trajectory_fitness(result, success, part_.settings.optimizer.settings.fitness) /
                   static_cast<double>(tries.results.size());
    ++rates.outcomes[config::enum_name(result.verdict.outcome)];
    if (const auto by = on_by(result.verdict); !by.empty()) ++rates.on[by];
  }
  return rates;
}

Result<std::vector<symbols::Experience>> Loop::experiences(std::size_t collection, const Tries& tries) const {
  std::vector<symbols::Experience> experiences;
  std::string lines;
  for (std::size_t i = 0; i < tries.results.size(); ++i) {
    const std::string id = id_ + "/" + part_.name + "/" + std::to_string(collection) + "/" + padded(i);
    experiences.push_back(experience_of(id, tries.rollouts[i], tries.results[i]));
    lines += symbols::to_json_line(experiences.back()) + "\n";
  }
  PRIMO_TRY(write_file(directory_ / ("experience-" + part_.name + "-" + std::to_string(collection) + ".jsonl"), lines));
  return experiences;
}

Result<std::vector<Literal>> Loop::desired_outcome(const rules::RuleSet& rules) const {
  std::vector<Literal> goal;
  for (const auto& words : part_.settings.goal) {
    PRIMO_ASSIGN(auto literal, symbols::literal_from_json(symbols::Json(words)));
    goal.push_back(std::move(literal));
  }
  auto desired = rules::desired_outcome(rules, part_.primitive.action, goal);
  if (!desired) {
    return Error{Code::failed, "no desired outcome to optimize for: " + desired.error().message +
                                   "; the primitive must succeed now and then, so give easier or more scenarios"};
  }
  return canonical(desired->literals, desired->rule.action);
}

Result<Collection> Loop::collect(const motion::Primitive& primitive, std::vector<Literal>& desired) {
  Collection collection;
  collection.primitive = primitive;
  const bool in_physics = part_.settings.experience.mode == physics::Mode::execute;
  Tries training = training_tries(primitive),
        displaced = displaced_tries(primitive, physics::Mode::final_pose, displaced_.size()),
        whole = displaced_tries(primitive, physics::Mode::execute, in_physics ? displaced_.size() : 0);
  const auto try_all = [&]() -> Status {
    PRIMO_TRY(trials_.evaluate(displaced, "collect"));
    if (in_physics) PRIMO_TRY(trials_.evaluate(whole, "execute"));
    return trials_.evaluate(training, "collect");
  };
  PRIMO_TRY(trials_.stage("collect", try_all));
  PRIMO_TRY(trials_.stage("learn", [&]() -> Status {
    PRIMO_ASSIGN(const auto seen, experiences(collections_, in_physics ? whole : displaced));
    PRIMO_ASSIGN(collection.rules, trials_.learn(id_ + "/" + part_.name + "/" + std::to_string(collections_), seen));
    if (const auto* rule = rule_of(collection.rules, part_.primitive.action)) {
      collection.untested_context = rules::untested_context(*rule, seen);
    }
    return success();
  }));
  if (desired.empty()) {
    PRIMO_ASSIGN(desired, desired_outcome(collection.rules));
  }
  collection.training = rates(training, desired);
  collection.displaced = rates(displaced, desired);
  ++collections_;
  return collection;
}

OptimizeGoal Loop::goal(const motion::Primitive& primitive, const std::vector<Literal>& desired) const {
  const auto& search = part_.settings.optimizer;
  OptimizeGoal goal;
  goal.study = id_;
  goal.part = part_.name;
  goal.round = trials_.round();
  goal.directory = fs::absolute(directory_).string();
  goal.primitive = primitive;
  if (part_.settings.protocol == Protocol::robust) {
    const auto& pool = part_.settings.pool;
    goal.scenarios = pool_;
    goal.estimates = pool_estimates_;
    goal.drawn = pool.drawn > 0 ? pool.drawn : static_cast<int>(part_.training.size());
    goal.held_out = pool.validation;
  } else {
    goal.scenarios = part_.training;
    goal.estimates = training_estimates_;
  }
  goal.desired = desired;
  goal.optimizer = search.of_optimizer();
  goal.algorithms = search.algorithms;
  goal.restarts = goal.round > 0 && search.later_restarts > 0 ? search.later_restarts : search.restarts;
  goal.judge = part_.settings.judge;
  goal.seed = part_.settings.seed;
  goal.settings = config::dump(search.settings);
  return goal;
}

Status Loop::execute(Collection& collection) {
  const auto count = static_cast<std::size_t>(part_.settings.executed);
  Tries whole = displaced_tries(collection.primitive, physics::Mode::execute, count);
  Tries judged = displaced_tries(collection.primitive, physics::Mode::final_pose, count);  // the journal knows them
  const auto try_both = [&]() -> Status {
    PRIMO_TRY(trials_.evaluate(whole, "execute"));
    return trials_.evaluate(judged, "execute");
  };
  PRIMO_TRY(trials_.stage("execute", try_both));
  for (std::size_t i = 0; i < whole.results.size(); ++i) {
    const bool worked = whole.results[i].verdict.final_pose_success;
    collection.executed.add(worked);
    if (judged.results[i].verdict.success) collection.executed_of_strict.add(worked);
  }
  return success();
}

Status Loop::observe() {
  const auto& settings = part_.settings.experience;
  PRIMO_ASSIGN(auto drawn, draw_displaced(robot_, part_.training, settings.displacement, settings.seed, 0,
                                          static_cast<std::size_t>(settings.scenarios), "_displaced_"));
  displaced_ = std::move(drawn.scenarios);
  if (part_.settings.protocol == Protocol::robust) {
    const auto& pool = part_.settings.pool;
    PRIMO_ASSIGN(pool_, draw_pool(robot_, part_.training, pool.scenarios, pool.displacement, pool.seed, "pool"));
    PRIMO_ASSIGN(auto held_out,
                 draw_pool(robot_, part_.training, pool.validation, pool.displacement, pool.validation_seed, "choice"));
    pool_.insert(pool_.end(), std::make_move_iterator(held_out.begin()), std::make_move_iterator(held_out.end()));
  }
  return trials_.stage("observe", [&]() -> Status {
    PRIMO_ASSIGN(training_estimates_, trials_.observe(part_.training));
    PRIMO_ASSIGN(displaced_estimates_, trials_.observe(displaced_));
    PRIMO_ASSIGN(pool_estimates_, trials_.observe(pool_));
    return success();
  });
}

/// Round after round, until the rules no longer change.
Status Loop::improve(PartResult& result) {
  std::vector<Literal> desired;
  PRIMO_ASSIGN(auto first, collect(part_.primitive, desired));
  result.collections.push_back(std::move(first));
  result.end = "as many rounds as the study allows";
  for (int round = 0; round < part_.settings.rounds; ++round) {
    trials_.set_round(round);
    const Collection& before = result.collections.back();
    if (round > 0) {
      PRIMO_ASSIGN(desired, desired_outcome(before.rules));
    }
    OptimizeResult optimized;
    PRIMO_TRY(trials_.stage("optimize", [&]() -> Status {
      const bool other = round == 0 && part_.structure;
      PRIMO_ASSIGN(optimized, trials_.optimize(goal(other ? *part_.structure : before.primitive, desired)));
      return success();
    }));
    PRIMO_ASSIGN(auto after, collect(optimized.primitive, desired));
    const bool changed = rules_changed(before.rules, after.rules);
    result.optimizations.push_back({desired, optimized.gamma, optimized.success, optimized.evaluations});
    result.collections.push_back(std::move(after));
    if (!changed) {
      result.end = "the rules no longer change beyond their 95 % intervals";
      break;
    }
  }
  return success();
}

Result<PartResult> Loop::run() {
  PartResult result;
  result.name = part_.name;
  result.action = part_.primitive.action;
  PRIMO_TRY(observe());
  PRIMO_TRY(improve(result));
  PRIMO_TRY(execute(result.collections.front()));
  PRIMO_TRY(execute(result.collections.back()));
  PRIMO_TRY(trials_.stage("generalize", [&]() -> Status {
    PRIMO_ASSIGN(result.levels, generalize(robot_, part_, id_ + "/" + part_.name, result.collections.front().primitive,
                                           result.collections.back().primitive, trials_));
    return success();
  }));
  return result;
}

}  // namespace

Result<StudyResult> run_study(const Study& study, const fs::path& directory, Workers& workers,
                              const OnProgress& on_progress) {
  if (auto status = study.validate(); !status.ok()) return status.error().at("study " + study.name);
  PRIMO_TRY(adopt_directory(study, directory));
  PRIMO_ASSIGN(const auto robot, robot::Robot::load(study.robot));
  PRIMO_ASSIGN(Journal journal, Journal::open(journal_file(directory)));
  StudyResult result;
  result.study = study.id();
  for (const auto& part : study.parts) {
    auto done = Loop(result.study, robot, part, directory, workers, journal, on_progress).run();
    if (!done) return study.parts.size() > 1 ? done.error().at("part " + part.name) : done.error();
    result.parts.push_back(std::move(*done));
  }
  PRIMO_TRY(write_file(directory / "result.json", to_json(result)));
  if (on_progress) {
    Progress progress;
    progress.study = result.study;
    progress.part = study.parts.back().name;
    progress.stage = "done";
    progress.done = progress.total = 1;
    progress.success = result.parts.back().collections.back().displaced.strict;
    progress.finished = true;
    progress.text = result.parts.back().end;
    on_progress(progress);
  }
  return result;
}

Result<OptimizeResult> optimize_in_directory(const OptimizeGoal& goal, Evaluator& evaluator,
                                             const OnProgress& on_progress) {
  PRIMO_ASSIGN(Journal journal, Journal::open(journal_file(goal.directory)));
  return optimize(goal, evaluator, journal, on_progress);
}

}  // namespace primo::study
