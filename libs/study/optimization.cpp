#include "study/optimization.h"

#include <algorithm>
#include <functional>
#include <memory>
#include <numeric>
#include <utility>

#include "core/random.h"
#include "study/candidates.h"
#include "study/pool.h"

namespace primo::study {
namespace {

/// A recommendation that the final choice is made among.
struct Finalist {
  FinalistRecord record;
  motion::Primitive primitive;
};

/// The best sample so far. Evaluated anew in each generation its γ is the mean over these.
struct Incumbent {
  std::vector<double> x;
  Score score;
  double gamma_sum = 0;
  int evaluations = 0;
  double gamma() const { return gamma_sum / std::max(1, evaluations); }
};

/// One algorithm from one random start.
struct Run {
  std::string algorithm;
  int restart = 0;
  std::unique_ptr<optim::Optimizer> optimizer;
  Incumbent best;
  int reevaluations = 0;            ///< of the incumbent; they are on the budget
  std::vector<double> best_course;  ///< best γ after each generation
  std::vector<double> mean_course;  ///< mean γ of each generation's candidates
  int full_success = 0;             ///< latest generations in a row in which a candidate succeeded everywhere
  int evaluations() const { return optimizer->evaluations() + reevaluations; }
};

class Optimization {
 public:
  Optimization(const OptimizeGoal& goal, const OptimizationSettings& settings, Evaluator& evaluator, Journal& journal,
               const OnProgress& on_progress)
      : goal_(goal),
        settings_(settings),
        entries_(goal.primitive.open_entries(settings.log_rho_min, settings.log_rho_max)),
        evaluator_(evaluator, journal),
        candidates_(goal_, settings_, evaluator_),
        journal_(journal),
        on_progress_(on_progress) {}

  Result<OptimizeResult> run();

 private:
  Result<Run> start(const std::string& algorithm, int restart) const;
  Status search(Run& run);
  Result<std::vector<Score>> scores_of(const Run& run, const std::vector<motion::Primitive>& primitives, int generation,
                                       std::size_t incumbent);
  Result<bool> may_stop(const Run& run, int generation);
  Status record(const Run& run, const std::vector<optim::Candidate>& candidates, const std::vector<Score>& scores);
  void report(const Run& run, const std::vector<Score>& scores, bool finished) const;
  void add_finalists(const Run& run);
  Result<OptimizeResult> choose();
  Status explore(const Finalist& chosen);
  SeedOf seeds_of(int generation) const;
  std::vector<SeedOf> validation_seeds() const;
  std::size_t pool() const { return goal_.scenarios.size() - static_cast<std::size_t>(goal_.held_out); }
  bool resampled() const { return goal_.drawn > 0 && static_cast<std::size_t>(goal_.drawn) < pool(); }
  std::vector<std::size_t> scenarios_of(int generation) const;
  std::vector<std::size_t> scenarios_of_choice() const;
  bool over(const Run& run) const;
  void learn(Run& run, const std::vector<optim::Candidate>& candidates, const std::vector<Score>& scores) const;

  const OptimizeGoal& goal_;
  const OptimizationSettings settings_;
  const std::vector<motion::OpenEntry> entries_;
  JournaledEvaluator evaluator_;
  Candidates candidates_;
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
  if (goal.held_out < 0 || static_cast<std::size_t>(goal.held_out) >= goal.scenarios.size()) {
    return wrong("held_out is " + std::to_string(goal.held_out) + ", must be 0 to " +
                 std::to_string(goal.scenarios.size() - 1) + ", so that a scenario is left to train on");
  }
  if (goal.drawn < 0) return wrong("drawn is " + std::to_string(goal.drawn) + ", must not be negative");
  if (goal.algorithms.empty())
    return wrong("no algorithm; known ones: " + config::detail::joined(optim::optimizer_names()));
  if (goal.restarts < 1) return wrong("restarts is " + std::to_string(goal.restarts) + ", must be at least 1");
  if (goal.desired.empty()) return wrong("no desired outcome");
  if (goal.primitive.open_entries(0, 1).empty())
    return wrong("primitive '" + goal.primitive.name + "' has no precision or other entry open to the optimizer");
  return success();
}

/// Whether the mean of the last `window` values is less than `tolerance` above that of as many before them.
bool level(const std::vector<double>& course, std::size_t window, double tolerance) {
  if (course.size() < 2 * window) return false;
  const auto end = course.end(), middle = end - static_cast<std::ptrdiff_t>(window);
  const double late = std::accumulate(middle, end, 0.0);
  const double early = std::accumulate(middle - static_cast<std::ptrdiff_t>(window), middle, 0.0);
  return late - early < tolerance * static_cast<double>(window);
}

Result<Run> Optimization::start(const std::string& algorithm, int restart) const {
  optim::OptimizerSettings settings = goal_.optimizer;
  settings.name = algorithm;
  settings.restart = restart;
  settings.seed = Random(goal_.seed, "optimizer", {static_cast<std::uint64_t>(goal_.round)}).bits();
  optim::Bounds bounds;
  for (const auto& entry : entries_) {
    bounds.lower.push_back(entry.lower);
    bounds.upper.push_back(entry.upper);
  }
  Run run;
  run.algorithm = algorithm;
  run.restart = restart;
  PRIMO_ASSIGN(run.optimizer, optim::make_optimizer(settings, bounds));
  return run;
}

SeedOf Optimization::seeds_of(int generation) const {
  return [this, generation](std::size_t candidate, std::size_t scenario) {
    return training_seed(goal_, generation, scenario, settings_.common_random_numbers ? 0 : candidate + 1);
  };
}

std::vector<std::size_t> Optimization::scenarios_of(int generation) const {
  return draw_from_pool(pool(), static_cast<std::size_t>(goal_.drawn), goal_.seed, goal_.round, generation);
}

std::vector<std::size_t> Optimization::scenarios_of_choice() const {
  const std::size_t first = goal_.held_out > 0 ? pool() : 0;
  std::vector<std::size_t> scenarios(goal_.scenarios.size() - first);
  std::iota(scenarios.begin(), scenarios.end(), first);
  return scenarios;
}

std::vector<SeedOf> Optimization::validation_seeds() const {
  std::vector<SeedOf> seeds;
  for (int repetition = 0; repetition < settings_.validation; ++repetition) {
    seeds.push_back([this, repetition](std::size_t, std::size_t scenario) {
      return validation_seed(goal_.seed, repetition, scenario);
    });
  }
  return seeds;
}

Status Optimization::record(const Run& run, const std::vector<optim::Candidate>& candidates,
                            const std::vector<Score>& scores) {
  std::vector<EvaluationRecord> records;
  for (std::size_t c = 0; c < candidates.size(); ++c) {
    EvaluationRecord record;
    record.part = goal_.part;
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
  progress.part = goal_.part;
  progress.round = goal_.round;
  progress.stage = "optimize";
  progress.algorithm = goal_.restarts > 1 ? run.algorithm + " " + std::to_string(run.restart + 1) : run.algorithm;
  progress.done = run.evaluations();
  progress.total = goal_.optimizer.evaluations;
  progress.best_gamma = run.best.gamma();
  for (const auto& score : scores) progress.mean_gamma += score.gamma / static_cast<double>(scores.size());
  progress.sigma = run.optimizer->sigma();
  progress.condition = run.optimizer->condition();
  progress.success = {run.best.score.successes, run.best.score.rollouts};
  progress.finished = finished;
  progress.text = run.optimizer->stop_reason();
  on_progress_(progress);
}

/// The conditions of EarlyStop, the cheap ones first: the recommendation is rolled out only when it may matter.
Result<bool> Optimization::may_stop(const Run& run, int generation) {
  const auto patience = static_cast<std::size_t>(settings_.early_stop.generations);
  if (resampled()) return patience > 0 && level(run.mean_course, patience, settings_.early_stop.tolerance);
  if (patience == 0 || run.full_success < settings_.early_stop.generations || run.best_course.size() <= patience)
    return false;
  const double before = run.best_course[run.best_course.size() - 1 - patience];
  if (run.best_course.back() - before >= settings_.early_stop.tolerance) return false;
  PRIMO_ASSIGN(const auto scores, candidates_.evaluate({goal_.primitive.with_entries(run.optimizer->recommendation())},
                                                       scenarios_of(generation), {seeds_of(generation)}));
  return scores[0].succeeded_everywhere();
}

/// Whether the next generation no longer fits into the budget, or the algorithm has ended itself.
bool Optimization::over(const Run& run) const {
  if (run.optimizer->done()) return true;
  const int incumbent = settings_.reevaluate_incumbent && !run.best.x.empty() ? 1 : 0;
  const int next = static_cast<int>(run.optimizer->ask().size()) + incumbent;
  return incumbent > 0 && run.evaluations() + next > goal_.optimizer.evaluations;
}

/// The incumbent after a generation: the greatest γ among the candidates that went through all scenarios, if it beats
/// the incumbent's.
void Optimization::learn(Run& run, const std::vector<optim::Candidate>& candidates,
                         const std::vector<Score>& scores) const {
  bool full = false;
  for (std::size_t c = 0; c < candidates.size(); ++c) {
    full = full || scores[c].succeeded_everywhere();
    if (!scores[c].whole || (run.best.evaluations > 0 && !(scores[c].gamma > run.best.gamma()))) continue;
    run.best = {candidates[c].x, scores[c], scores[c].gamma, 1};
  }
  run.full_success = full ? run.full_success + 1 : 0;
  run.best_course.push_back(run.best.gamma());
  double sum = 0;
  for (const auto& score : scores) sum += score.gamma;
  run.mean_course.push_back(sum / static_cast<double>(scores.size()));
}

/// The primitives of a generation, the incumbent first where it is evaluated anew. Where only the best sample counts
/// and all generations meet the same scenarios, no more is rolled out than decides whether a candidate is it.
Result<std::vector<Score>> Optimization::scores_of(const Run& run, const std::vector<motion::Primitive>& primitives,
                                                   int generation, std::size_t incumbent) {
  const auto scenarios = scenarios_of(generation);
  const bool contest = settings_.give_up && run.optimizer->keeps_only_best() && run.best.evaluations > 0 &&
                       !settings_.reevaluate_incumbent && settings_.racing.rounds.empty() && !resampled();
  if (contest) return candidates_.contest(primitives, scenarios, seeds_of(generation), run.best.gamma());
  return candidates_.race(primitives, scenarios, seeds_of(generation), static_cast<std::size_t>(generation), incumbent);
}

Status Optimization::search(Run& run) {
  bool stop = false;
  while (!stop && !over(run)) {
    const auto candidates = run.optimizer->ask();
    PRIMO_CHECK(!candidates.empty(), "an optimizer that is not done asks for candidates");
    const int generation = candidates.front().generation;
    std::vector<motion::Primitive> primitives;
    const std::size_t incumbent = settings_.reevaluate_incumbent && !run.best.x.empty() ? 1 : 0;
    if (incumbent > 0) primitives.push_back(goal_.primitive.with_entries(run.best.x));
    for (const auto& candidate : candidates) primitives.push_back(goal_.primitive.with_entries(candidate.x));
    PRIMO_ASSIGN(auto scores, scores_of(run, primitives, generation, incumbent));
    if (incumbent > 0) {
      run.best.gamma_sum += scores.front().gamma;
      ++run.best.evaluations;
      ++run.reevaluations;
      scores.erase(scores.begin());
    }
    for (std::size_t c = 0; c < candidates.size(); ++c) {
      PRIMO_TRY(run.optimizer->tell(generation, candidates[c].index, scores[c].rank));
    }
    learn(run, candidates, scores);
    PRIMO_TRY(record(run, candidates, scores));
    PRIMO_ASSIGN(stop, may_stop(run, generation));
    report(run, scores, stop || over(run));
  }
  evaluations_ += run.evaluations();
  return success();
}

void Optimization::add_finalists(const Run& run) {
  const auto add = [&](const char* kind, const std::vector<double>& x) {
    Finalist finalist;
    finalist.record.part = goal_.part;
    finalist.record.round = goal_.round;
    finalist.record.algorithm = run.algorithm;
    finalist.record.restart = run.restart;
    finalist.record.kind = kind;
    finalist.record.x = x;
    finalist.primitive = goal_.primitive.with_entries(x);
    finalist.primitive.name = goal_.primitive.action + "_optimized_" + std::to_string(goal_.round + 1);
    finalists_.push_back(std::move(finalist));
  };
  const auto mean = run.optimizer->recommendation();
  const auto& best = run.best.x;
  const bool same = best == mean || best.empty();
  if (settings_.recommendation != Recommendation::best || best.empty()) add(same ? "best" : "mean", mean);
  if (settings_.recommendation != Recommendation::mean && !same) add("best", best);
  if (settings_.recommendation == Recommendation::best && best == mean) add("best", best);
}

Result<OptimizeResult> Optimization::choose() {
  std::vector<motion::Primitive> primitives;
  for (const auto& finalist : finalists_) primitives.push_back(finalist.primitive);
  PRIMO_ASSIGN(const auto scores, candidates_.evaluate(primitives, scenarios_of_choice(), validation_seeds()));
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
  PRIMO_TRY(explore(finalists_[chosen]));

  OptimizeResult result;
  result.study = goal_.study;
  result.round = goal_.round;
  result.primitive = finalists_[chosen].primitive;
  result.gamma = finalists_[chosen].record.gamma;
  result.success = finalists_[chosen].record.success;
  result.evaluations = evaluations_;
  return result;
}

/// What γ does around the chosen primitive: each open entry by itself a step down and a step up, as far as its bounds
/// go, on the scenarios and seeds of the choice.
Status Optimization::explore(const Finalist& chosen) {
  if (settings_.sensitivity == 0) return success();
  std::vector<SensitivityRecord> records;
  std::vector<motion::Primitive> primitives;
  for (std::size_t i = 0; i < entries_.size(); ++i) {
    const auto& entry = entries_[i];
    const double value = chosen.record.x[i], step = settings_.sensitivity * (entry.upper - entry.lower);
    SensitivityRecord record;
    record.part = goal_.part;
    record.round = goal_.round;
    record.index = static_cast<int>(i);
    record.entry = entry.name;
    record.log = entry.log;
    record.x = {value, std::max(value - step, std::min(value, entry.lower)),
                std::min(value + step, std::max(value, entry.upper))};
    for (const std::size_t side : {1, 2}) {
      auto x = chosen.record.x;
      x[i] = record.x[side];
      primitives.push_back(chosen.primitive.with_entries(x));
    }
    record.gamma[0] = chosen.record.gamma;
    record.success[0] = chosen.record.success;
    records.push_back(record);
  }
  PRIMO_ASSIGN(const auto scores, candidates_.evaluate(primitives, scenarios_of_choice(), validation_seeds()));
  for (std::size_t i = 0; i < scores.size(); ++i) {
    records[i / 2].gamma[1 + i % 2] = scores[i].gamma;
    records[i / 2].success[1 + i % 2] = {scores[i].successes, scores[i].rollouts};
  }
  return journal_.record_sensitivities(records);
}

Result<OptimizeResult> Optimization::run() {
  // P itself stands for election too: an optimization that finds nothing better must not make things worse.
  Finalist start_primitive;
  start_primitive.record.part = goal_.part;
  start_primitive.record.round = goal_.round;
  start_primitive.record.algorithm = "P";
  start_primitive.record.kind = "start";
  for (const auto& entry : entries_) start_primitive.record.x.push_back(entry.value);
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
  if (std::adjacent_find(racing.rounds.begin(), racing.rounds.end(), std::greater_equal<>()) != racing.rounds.end()) {
    return Error{Code::config, "'racing.rounds' must rise: after how many scenarios in all each round ends"};
  }
  return fitness.validate();
}

std::uint64_t training_seed(const OptimizeGoal& goal, int generation, std::size_t scenario, std::size_t candidate) {
  const auto round = static_cast<std::uint64_t>(goal.round), number = static_cast<std::uint64_t>(generation);
  if (candidate == 0) return Random(goal.seed, "training", {round, number, scenario}).bits();
  return Random(goal.seed, "training of each", {round, number, scenario, candidate}).bits();
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
