#include "study/optimization.h"

#include <algorithm>
#include <memory>
#include <utility>

#include "core/random.h"
#include "study/rollout.h"

namespace primo::study {
namespace {

/// γ of one primitive on a set of rollouts, and how often it succeeded there.
struct Score {
  double gamma = 0;
  int successes = 0;
  int final_pose = 0;
  int rollouts = 0;
};

/// A recommendation that the final choice is made among.
struct Finalist {
  FinalistRecord record;
  motion::Primitive primitive;
};

/// One algorithm from one random start.
struct Run {
  std::string algorithm;
  int restart = 0;
  std::unique_ptr<optim::Optimizer> optimizer;
  Score best;  ///< of the best sample so far
  double best_gamma = 0;
  std::vector<double> best_course;  ///< best γ after each generation
  int full_success = 0;             ///< latest generations in a row in which a candidate succeeded everywhere
};

class Optimization {
 public:
  Optimization(const OptimizeGoal& goal, const OptimizationSettings& settings, Evaluator& evaluator, Journal& journal,
               const OnProgress& on_progress)
      : goal_(goal),
        settings_(settings),
        evaluator_(evaluator, journal),
        journal_(journal),
        on_progress_(on_progress) {}

  Result<OptimizeResult> run();

 private:
  using SeedOf = std::function<std::uint64_t(std::size_t scenario)>;

  Result<Run> start(const std::string& algorithm, int restart) const;
  Status search(Run& run);
  Result<bool> may_stop(const Run& run, int generation);
  Result<std::vector<Score>> evaluate(const std::vector<motion::Primitive>& primitives,
                                      const std::vector<SeedOf>& seeds);
  Status record(const Run& run, const std::vector<optim::Candidate>& candidates, const std::vector<Score>& scores);
  void report(const Run& run, const std::vector<Score>& scores, bool finished) const;
  void add_finalists(const Run& run);
  Result<OptimizeResult> choose();

  const OptimizeGoal& goal_;
  const OptimizationSettings settings_;
  JournaledEvaluator evaluator_;
  Journal& journal_;
  const OnProgress& on_progress_;
  std::vector<Finalist> finalists_;
  int evaluations_ = 0;
};

Status validate(const OptimizeGoal& goal) {
  const auto wrong = [](const std::string& message) { return Error{Code::data, "optimization goal: " + message}; };
  if (goal.scenarios.empty()) return wrong("no training scenarios");
  if (goal.estimates.size() != goal.scenarios.size()) {
    return wrong(std::to_string(goal.estimates.size()) + " scene estimates for " +
                 std::to_string(goal.scenarios.size()) + " scenarios");
  }
  if (goal.algorithms.empty())
    return wrong("no algorithm; known ones: " + config::detail::joined(optim::optimizer_names()));
  if (goal.restarts < 1) return wrong("restarts is " + std::to_string(goal.restarts) + ", must be at least 1");
  if (goal.desired.empty()) return wrong("no desired outcome");
  if (goal.primitive.log_rho().empty())
    return wrong("primitive '" + goal.primitive.name + "' has no precision open to the optimizer");
  return success();
}

Result<Run> Optimization::start(const std::string& algorithm, int restart) const {
  optim::OptimizerSettings settings = goal_.optimizer;
  settings.name = algorithm;
  settings.restart = restart;
  settings.seed = Random(goal_.seed, "optimizer", {static_cast<std::uint64_t>(goal_.round)}).bits();
  const std::size_t dimension = goal_.primitive.log_rho().size();
  const optim::Bounds bounds{std::vector<double>(dimension, settings_.log_rho_min),
                             std::vector<double>(dimension, settings_.log_rho_max)};
  Run run;
  run.algorithm = algorithm;
  run.restart = restart;
  PRIMO_ASSIGN(run.optimizer, optim::make_optimizer(settings, bounds));
  return run;
}

Result<std::vector<Score>> Optimization::evaluate(const std::vector<motion::Primitive>& primitives,
                                                  const std::vector<SeedOf>& seeds) {
  const std::size_t scenarios = goal_.scenarios.size();
  const std::size_t each = scenarios * seeds.size();
  std::vector<Rollout> rollouts;
  rollouts.reserve(primitives.size() * each);
  for (const auto& primitive : primitives) {
    for (const auto& seed_of : seeds) {
      for (std::size_t k = 0; k < scenarios; ++k) {
        rollouts.push_back(
            {goal_.scenarios[k], goal_.estimates[k], primitive, seed_of(k), physics::Mode::final_pose, goal_.judge});
      }
    }
  }
  std::vector<double> g(rollouts.size(), 0);
  std::vector<Score> scores(primitives.size());
  std::string refused;
  PRIMO_TRY(evaluator_.evaluate(rollouts, [&](std::size_t i, const RolloutResult& result) {
    const std::size_t k = i % scenarios;
    if (result.plan_status == motion::PlanStatus::bad_input)
      refused = goal_.scenarios[k].name + ": " + result.plan_reason;
    const bool success = succeeded(result, goal_.desired, goal_.scenarios[k].action);
    g[i] = trajectory_fitness(result, success, settings_.fitness);
    Score& score = scores[i / each];
    score.successes += success;
    score.final_pose += result.verdict.final_pose_success;
  }));
  if (!refused.empty()) return Error{Code::failed, "the planner refused a request of the optimization: " + refused};
  for (std::size_t p = 0; p < primitives.size(); ++p) {
    scores[p].gamma = fitness(std::span<const double>(g).subspan(p * each, each));
    scores[p].rollouts = static_cast<int>(each);
  }
  return scores;
}

Status Optimization::record(const Run& run, const std::vector<optim::Candidate>& candidates,
                            const std::vector<Score>& scores) {
  std::vector<EvaluationRecord> records;
  for (std::size_t c = 0; c < candidates.size(); ++c) {
    EvaluationRecord record;
    record.round = goal_.round;
    record.algorithm = run.algorithm;
    record.restart = run.restart;
    record.generation = candidates[c].generation;
    record.index = candidates[c].index;
    record.gamma = scores[c].gamma;
    record.successes = scores[c].successes;
    record.final_pose = scores[c].final_pose;
    record.scenarios = scores[c].rollouts;
    record.x = candidates[c].x;
    records.push_back(std::move(record));
  }
  return journal_.record_evaluations(records);
}

void Optimization::report(const Run& run, const std::vector<Score>& scores, bool finished) const {
  if (!on_progress_) return;
  Progress progress;
  progress.study = goal_.study;
  progress.round = goal_.round;
  progress.stage = "optimize";
  progress.algorithm = goal_.restarts > 1 ? run.algorithm + " " + std::to_string(run.restart + 1) : run.algorithm;
  progress.done = run.optimizer->evaluations();
  progress.total = goal_.optimizer.evaluations;
  progress.best_gamma = run.best_gamma;
  for (const auto& score : scores) progress.mean_gamma += score.gamma / static_cast<double>(scores.size());
  progress.success = {run.best.successes, run.best.rollouts};
  progress.finished = finished;
  progress.text = run.optimizer->stop_reason();
  on_progress_(progress);
}

/// The conditions of EarlyStop, the cheap ones first: the recommendation is rolled out only when it may matter.
Result<bool> Optimization::may_stop(const Run& run, int generation) {
  const auto patience = static_cast<std::size_t>(settings_.early_stop.generations);
  if (patience == 0 || run.full_success < settings_.early_stop.generations || run.best_course.size() <= patience)
    return false;
  const double before = run.best_course[run.best_course.size() - 1 - patience];
  if (run.best_course.back() - before >= settings_.early_stop.tolerance) return false;
  PRIMO_ASSIGN(const auto scores, evaluate({goal_.primitive.with_log_rho(run.optimizer->recommendation())},
                                           {[&](std::size_t k) { return training_seed(goal_, generation, k); }}));
  return scores[0].successes == scores[0].rollouts;
}

Status Optimization::search(Run& run) {
  bool stop = false;
  while (!stop && !run.optimizer->done()) {
    const auto candidates = run.optimizer->ask();
    PRIMO_CHECK(!candidates.empty(), "an optimizer that is not done asks for candidates");
    const int generation = candidates.front().generation;
    std::vector<motion::Primitive> primitives;
    for (const auto& candidate : candidates) primitives.push_back(goal_.primitive.with_log_rho(candidate.x));
    PRIMO_ASSIGN(const auto scores,
                 evaluate(primitives, {[&](std::size_t k) { return training_seed(goal_, generation, k); }}));
    bool full = false;
    for (std::size_t c = 0; c < candidates.size(); ++c) {
      PRIMO_TRY(run.optimizer->tell(generation, candidates[c].index, scores[c].gamma));
      if (run.best.rollouts == 0 || scores[c].gamma > run.best_gamma) {
        run.best = scores[c];
        run.best_gamma = scores[c].gamma;
      }
      full = full || scores[c].successes == scores[c].rollouts;
    }
    run.full_success = full ? run.full_success + 1 : 0;
    run.best_course.push_back(run.best_gamma);
    PRIMO_TRY(record(run, candidates, scores));
    PRIMO_ASSIGN(stop, may_stop(run, generation));
    report(run, scores, stop || run.optimizer->done());
  }
  evaluations_ += run.optimizer->evaluations();
  return success();
}

void Optimization::add_finalists(const Run& run) {
  const auto add = [&](const char* kind, const std::vector<double>& x) {
    Finalist finalist;
    finalist.record.round = goal_.round;
    finalist.record.algorithm = run.algorithm;
    finalist.record.restart = run.restart;
    finalist.record.kind = kind;
    finalist.record.x = x;
    finalist.primitive = goal_.primitive.with_log_rho(x);
    finalist.primitive.name = goal_.primitive.action + "_optimized_" + std::to_string(goal_.round + 1);
    finalists_.push_back(std::move(finalist));
  };
  const auto recommendation = run.optimizer->recommendation();
  add("mean", recommendation);
  if (run.optimizer->best() != recommendation) add("best", run.optimizer->best());
}

Result<OptimizeResult> Optimization::choose() {
  std::vector<motion::Primitive> primitives;
  for (const auto& finalist : finalists_) primitives.push_back(finalist.primitive);
  std::vector<SeedOf> seeds;
  for (int repetition = 0; repetition < settings_.validation; ++repetition) {
    seeds.push_back([this, repetition](std::size_t k) { return validation_seed(goal_.seed, repetition, k); });
  }
  PRIMO_ASSIGN(const auto scores, evaluate(primitives, seeds));
  std::size_t chosen = 0;
  for (std::size_t f = 0; f < finalists_.size(); ++f) {
    finalists_[f].record.gamma = scores[f].gamma;
    finalists_[f].record.success = {scores[f].successes, scores[f].rollouts};
    if (scores[f].gamma > scores[chosen].gamma) chosen = f;  // of equals the first
  }
  finalists_[chosen].record.chosen = true;
  std::vector<FinalistRecord> records;
  for (const auto& finalist : finalists_) records.push_back(finalist.record);
  PRIMO_TRY(journal_.record_finalists(records));

  OptimizeResult result;
  result.study = goal_.study;
  result.round = goal_.round;
  result.primitive = finalists_[chosen].primitive;
  result.gamma = finalists_[chosen].record.gamma;
  result.success = finalists_[chosen].record.success;
  result.evaluations = evaluations_;
  return result;
}

Result<OptimizeResult> Optimization::run() {
  // P itself stands for election too: an optimization that finds nothing better must not make things worse.
  Finalist start_primitive;
  start_primitive.record.round = goal_.round;
  start_primitive.record.algorithm = "P";
  start_primitive.record.kind = "start";
  start_primitive.record.x = goal_.primitive.log_rho();
  start_primitive.primitive = goal_.primitive;
  finalists_.push_back(std::move(start_primitive));
  for (const auto& algorithm : goal_.algorithms) {
    for (int restart = 0; restart < goal_.restarts; ++restart) {
      PRIMO_ASSIGN(Run run, start(algorithm, restart));
      PRIMO_TRY(search(run));
      add_finalists(run);
    }
  }
  return choose();
}

}  // namespace

Status OptimizationSettings::validate() const {
  if (log_rho_min >= log_rho_max) {
    return Error{Code::config, "'log_rho_min' is " + config::detail::format(log_rho_min) +
                                   ", must be below 'log_rho_max', " + config::detail::format(log_rho_max)};
  }
  return fitness.validate();
}

std::uint64_t training_seed(const OptimizeGoal& goal, int generation, std::size_t scenario) {
  return Random(goal.seed, "training",
                {static_cast<std::uint64_t>(goal.round), static_cast<std::uint64_t>(generation), scenario})
      .bits();
}

std::uint64_t validation_seed(std::uint64_t seed, int repetition, std::size_t scenario) {
  return Random(seed, "validation", {static_cast<std::uint64_t>(repetition), scenario}).bits();
}

Result<OptimizeResult> optimize(const OptimizeGoal& goal, Evaluator& evaluator, Journal& journal,
                                const OnProgress& on_progress) {
  PRIMO_TRY(validate(goal));
  OptimizationSettings settings;
  if (!goal.settings.empty()) {
    PRIMO_ASSIGN(settings, config::read_text<OptimizationSettings>(goal.settings, "settings of the optimization goal"));
  }
  return Optimization(goal, settings, evaluator, journal, on_progress).run();
}

}  // namespace primo::study
