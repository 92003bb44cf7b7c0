#include "study/loop.h"

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <iterator>
#include <optional>
#include <utility>

#include "core/files.h"
#include "core/hash.h"
#include "core/random.h"
#include "rules/learner.h"
#include "rules/prediction.h"
#include "scene/generator.h"
#include "study/codec.h"
#include "study/rollout.h"
#include "symbols/literal_json.h"

namespace primo::study {
namespace {

namespace fs = std::filesystem;
using Clock = std::chrono::steady_clock;
using symbols::Literal;

/// How many scenes are asked for at once: so much work at most is done again after a kill.
constexpr std::size_t kObserveBatch = 8;

std::string padded(std::size_t i) {
  char text[24];
  std::snprintf(text, sizeof text, "%05zu", i);
  return text;
}

/// Rollouts of one primitive and what came of them.
struct Tries {
  std::vector<Rollout> rollouts;
  std::vector<RolloutResult> results;
};

class Loop {
 public:
  Loop(const Study& study, const fs::path& directory, Workers& workers, Journal& journal, const OnProgress& on_progress)
      : study_(study),
        directory_(directory),
        workers_(workers),
        journal_(journal),
        evaluator_(workers, journal),
        on_progress_(on_progress),
        id_(study.id()) {}

  Result<StudyResult> run();

 private:
  /// Reports and times a stage. @pre work returns a Status.
  template <class F>
  Status stage(int round, const std::string& name, F&& work);
  void progress(const std::string& stage, int done, int total, const Rate& success = {}, bool finished = false,
                const std::string& text = "") const;

  Status make_scenarios();
  Result<std::vector<scene::SceneEstimate>> observe(const std::vector<scene::Scenario>& scenarios);
  Status evaluate(Tries& tries, const std::string& stage_name);
  Tries training_tries(const motion::Primitive& primitive) const;
  Tries displaced_tries(const motion::Primitive& primitive, physics::Mode mode, std::size_t count) const;
  Rates rates(const Tries& tries, const std::vector<Literal>& desired) const;
  Result<std::vector<symbols::Experience>> experiences(std::size_t collection, const Tries& tries) const;
  Result<rules::RuleSet> learn(std::size_t collection, const std::vector<symbols::Experience>& experiences);
  Result<std::vector<Literal>> desired_outcome(const rules::RuleSet& rules) const;
  /// Tries the primitive everywhere and learns from it. Without a desired outcome yet, it becomes that of the rules
  /// learned here.
  Result<Collection> collect(const motion::Primitive& primitive, std::vector<Literal>& desired);
  Result<OptimizeResult> optimize(const motion::Primitive& primitive, const std::vector<Literal>& desired);
  Status execute(Collection& collection);

  const Study& study_;
  const fs::path directory_;
  Workers& workers_;
  Journal& journal_;
  JournaledEvaluator evaluator_;
  const OnProgress& on_progress_;
  const std::string id_;
  int round_ = 0;
  std::size_t collections_ = 0;
  std::vector<scene::Scenario> displaced_;
  std::vector<scene::SceneEstimate> training_estimates_, displaced_estimates_;
  std::vector<scene::Scenario> pool_;  // robust protocol: what generations draw from, then what the choice is made on
  std::vector<scene::SceneEstimate> pool_estimates_;
};

template <class F>
Status Loop::stage(int round, const std::string& name, F&& work) {
  const auto begin = Clock::now();
  const auto asked = evaluator_.asked();
  PRIMO_TRY(work());
  const double seconds = std::chrono::duration<double>(Clock::now() - begin).count();
  return journal_.record_timing({round, name, seconds, evaluator_.asked() - asked});
}

void Loop::progress(const std::string& stage, int done, int total, const Rate& success, bool finished,
                    const std::string& text) const {
  if (!on_progress_) return;
  Progress progress;
  progress.study = id_;
  progress.round = round_;
  progress.stage = stage;
  progress.done = done;
  progress.total = total;
  progress.success = success;
  progress.finished = finished;
  progress.text = text;
  on_progress_(progress);
}

Status Loop::make_scenarios() {
  const auto& settings = study_.settings.experience;
  for (int i = 0; i < settings.scenarios; ++i) {
    const auto& base = study_.training[static_cast<std::size_t>(i) % study_.training.size()];
    PRIMO_ASSIGN(auto drawn,
                 scene::displace(base, settings.displacement, settings.seed, static_cast<std::uint64_t>(i)));
    drawn.scenario.name = base.name + "_displaced_" + std::to_string(i);
    displaced_.push_back(std::move(drawn.scenario));
  }
  if (study_.settings.protocol == Protocol::paper) return success();
  const auto& pool = study_.settings.pool;
  PRIMO_ASSIGN(pool_, draw_pool(study_.training, pool.scenarios, pool.displacement, pool.seed, "pool"));
  PRIMO_ASSIGN(auto held_out,
               draw_pool(study_.training, pool.validation, pool.displacement, pool.validation_seed, "choice"));
  pool_.insert(pool_.end(), std::make_move_iterator(held_out.begin()), std::make_move_iterator(held_out.end()));
  return success();
}

Result<std::vector<scene::SceneEstimate>> Loop::observe(const std::vector<scene::Scenario>& scenarios) {
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
    const double seconds =
        std::chrono::duration<double>(Clock::now() - asked_at).count() / static_cast<double>(batch.size());
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

Status Loop::evaluate(Tries& tries, const std::string& stage_name) {
  tries.results.resize(tries.rollouts.size());
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

Tries Loop::training_tries(const motion::Primitive& primitive) const {
  Tries tries;
  for (int repetition = 0; repetition < study_.settings.optimizer.settings.validation; ++repetition) {
    for (std::size_t k = 0; k < study_.training.size(); ++k) {
      tries.rollouts.push_back({study_.training[k], training_estimates_[k], primitive,
                                validation_seed(study_.settings.seed, repetition, k), physics::Mode::final_pose,
                                study_.settings.judge});
    }
  }
  return tries;
}

Tries Loop::displaced_tries(const motion::Primitive& primitive, physics::Mode mode, std::size_t count) const {
  Tries tries;
  for (std::size_t i = 0; i < std::min(count, displaced_.size()); ++i) {
    const auto seed = Random(study_.settings.experience.seed, "experience", {i}).bits();
    tries.rollouts.push_back({displaced_[i], displaced_estimates_[i], primitive, seed, mode, study_.settings.judge});
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
    rates.gamma += trajectory_fitness(result, success, study_.settings.optimizer.settings.fitness) /
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
    const auto& action = tries.rollouts[i].scenario.action;
    const auto& verdict = tries.results[i].verdict;
    symbols::Experience experience;
    experience.id = id_ + "/" + std::to_string(collection) + "/" + padded(i);
    experience.objects = verdict.objects;
    experience.before = verdict.before;
    experience.action = {action.front(), {action.begin() + 1, action.end()}, false};
    experience.after = verdict.after;
    lines += symbols::to_json_line(experience) + "\n";
    experiences.push_back(std::move(experience));
  }
  PRIMO_TRY(write_file(directory_ / ("experience-" + std::to_string(collection) + ".jsonl"), lines));
  return experiences;
}

Result<rules::RuleSet> Loop::learn(std::size_t collection, const std::vector<symbols::Experience>& experiences) {
  const std::string key = key_of(experiences);
  PRIMO_ASSIGN(auto reply, journal_.find(key));
  if (!reply) {
    const auto asked_at = Clock::now();
    PRIMO_ASSIGN(const auto learned,
                 workers_.learn(id_ + "/" + std::to_string(collection) + "-" + key.substr(0, 8), experiences));
    const double seconds = std::chrono::duration<double>(Clock::now() - asked_at).count();
    const Answer answer{key, "learn", rules::to_json(learned), seconds};
    PRIMO_ASSIGN(const auto replies, journal_.record({&answer, 1}));
    reply = replies.front();
  }
  progress("learn", static_cast<int>(experiences.size()), static_cast<int>(experiences.size()), {}, true);
  return rules::rules_from_json(*reply);
}

Result<std::vector<Literal>> Loop::desired_outcome(const rules::RuleSet& rules) const {
  std::vector<Literal> goal;
  for (const auto& words : study_.settings.goal) {
    PRIMO_ASSIGN(auto literal, symbols::literal_from_json(symbols::Json(words)));
    goal.push_back(std::move(literal));
  }
  auto desired = rules::desired_outcome(rules, study_.primitive.action, goal);
  if (!desired) {
    return Error{Code::failed, "no desired outcome to optimize for: " + desired.error().message +
                                   "; the primitive must succeed now and then, so give easier or more scenarios"};
  }
  return canonical(desired->literals, desired->rule.action);
}

Result<Collection> Loop::collect(const motion::Primitive& primitive, std::vector<Literal>& desired) {
  Collection collection;
  collection.primitive = primitive;
  Tries training = training_tries(primitive),
        displaced = displaced_tries(primitive, physics::Mode::final_pose, displaced_.size());
  const auto try_both = [&]() -> Status {
    PRIMO_TRY(evaluate(displaced, "collect"));
    return evaluate(training, "collect");
  };
  PRIMO_TRY(stage(round_, "collect", try_both));
  PRIMO_TRY(stage(round_, "learn", [&]() -> Status {
    PRIMO_ASSIGN(const auto seen, experiences(collections_, displaced));
    PRIMO_ASSIGN(collection.rules, learn(collections_, seen));
    if (const auto* rule = rule_of(collection.rules, study_.primitive.action)) {
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

Result<OptimizeResult> Loop::optimize(const motion::Primitive& primitive, const std::vector<Literal>& desired) {
  const auto& search = study_.settings.optimizer;
  OptimizeGoal goal;
  goal.study = id_;
  goal.round = round_;
  goal.directory = fs::absolute(directory_).string();
  goal.primitive = primitive;
  if (study_.settings.protocol == Protocol::robust) {
    const auto& pool = study_.settings.pool;
    goal.scenarios = pool_;
    goal.estimates = pool_estimates_;
    goal.drawn = pool.drawn > 0 ? pool.drawn : static_cast<int>(study_.training.size());
    goal.held_out = pool.validation;
  } else {
    goal.scenarios = study_.training;
    goal.estimates = training_estimates_;
  }
  goal.desired = desired;
  goal.optimizer.name = search.algorithms.front();
  goal.optimizer.evaluations = search.evaluations;
  goal.optimizer.population = search.population;
  goal.optimizer.sigma = search.sigma;
  goal.optimizer.on_stagnation = search.on_stagnation;
  goal.algorithms = search.algorithms;
  goal.restarts = search.restarts;
  goal.judge = study_.settings.judge;
  goal.seed = study_.settings.seed;
  goal.settings = config::dump(search.settings);
  const std::string key = key_of(goal);
  PRIMO_ASSIGN(auto reply, journal_.find(key));
  if (!reply) {
    const auto asked_at = Clock::now();
    PRIMO_ASSIGN(const auto found, workers_.optimize(goal));
    const double seconds = std::chrono::duration<double>(Clock::now() - asked_at).count();
    const Answer answer{key, "optimize", encode(found), seconds};
    PRIMO_ASSIGN(const auto replies, journal_.record({&answer, 1}));
    reply = replies.front();
  }
  return decode_optimize_result(*reply);
}

Status Loop::execute(Collection& collection) {
  const auto count = static_cast<std::size_t>(study_.settings.executed);
  Tries whole = displaced_tries(collection.primitive, physics::Mode::execute, count);
  Tries judged = displaced_tries(collection.primitive, physics::Mode::final_pose, count);  // the journal knows them
  PRIMO_TRY(stage(round_, "execute", [&] { return evaluate(whole, "execute"); }));
  PRIMO_TRY(evaluator_.evaluate(judged.rollouts, [&](std::size_t i, const RolloutResult& result) {
    const bool held = whole.results[i].verdict.final_pose_success;
    collection.executed.add(held);
    if (result.verdict.success) collection.executed_of_strict.add(held);
  }));
  return success();
}

Result<StudyResult> Loop::run() {
  StudyResult result;
  result.study = id_;
  result.action = study_.primitive.action;
  PRIMO_TRY(make_scenarios());
  PRIMO_TRY(stage(0, "observe", [&]() -> Status {
    PRIMO_ASSIGN(training_estimates_, observe(study_.training));
    PRIMO_ASSIGN(displaced_estimates_, observe(displaced_));
    PRIMO_ASSIGN(pool_estimates_, observe(pool_));
    return success();
  }));
  std::vector<Literal> desired;
  PRIMO_ASSIGN(auto first, collect(study_.primitive, desired));
  result.collections.push_back(std::move(first));
  result.end = "as many rounds as the study allows";
  for (round_ = 0; round_ < study_.settings.rounds; ++round_) {
    const Collection& before = result.collections.back();
    if (round_ > 0) {
      PRIMO_ASSIGN(desired, desired_outcome(before.rules));
    }
    OptimizeResult optimized;
    PRIMO_TRY(stage(round_, "optimize", [&]() -> Status {
      PRIMO_ASSIGN(optimized, optimize(before.primitive, desired));
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
  round_ = static_cast<int>(result.optimizations.size()) - 1;
  PRIMO_TRY(execute(result.collections.front()));
  PRIMO_TRY(execute(result.collections.back()));
  PRIMO_TRY(write_file(directory_ / "result.json", to_json(result)));
  progress("done", 1, 1, result.collections.back().displaced.strict, true, result.end);
  return result;
}

}  // namespace

Result<StudyResult> run_study(const Study& study, const fs::path& directory, Workers& workers,
                              const OnProgress& on_progress) {
  if (auto status = study.validate(); !status.ok()) return status.error().at("study " + study.name);
  PRIMO_TRY(adopt_directory(study, directory));
  PRIMO_ASSIGN(Journal journal, Journal::open(journal_file(directory)));
  return Loop(study, directory, workers, journal, on_progress).run();
}

Result<OptimizeResult> optimize_in_directory(const OptimizeGoal& goal, Evaluator& evaluator,
                                             const OnProgress& on_progress) {
  PRIMO_ASSIGN(Journal journal, Journal::open(journal_file(goal.directory)));
  return optimize(goal, evaluator, journal, on_progress);
}

}  // namespace primo::study
