// P* = argmax γ(P) over log10 ρ (paper, eq. 4): ask/tell optimizers on γ of Algorithm 1, with common random numbers
// within a generation.
#pragma once

#include <functional>
#include <string>

#include "study/backend.h"
#include "study/fitness.h"
#include "study/journal.h"

namespace primo::study {

/// Ends an algorithm before its budget is spent: when in each of the last `generations` generations some candidate
/// succeeded in all scenarios, the best γ rose by less than `tolerance` over them, and the recommendation itself
/// succeeds in all scenarios.
struct EarlyStop {
  int generations = 0;
  double tolerance = 0.01;
  template <class V>
  void visit(V&& v) {
    v("generations", generations,
      {.help = "generations of full success without progress after which to stop; 0: never", .min = 0, .max = 1e6});
    v("tolerance", tolerance, {.help = "rise of the best γ that counts as progress", .min = 0, .max = 10});
  }
};

/// What OptimizeGoal::settings holds as YAML.
struct OptimizationSettings {
  FitnessSettings fitness;
  EarlyStop early_stop;
  int validation = 3;
  double log_rho_min = -3, log_rho_max = 9;
  template <class V>
  void visit(V&& v) {
    v("fitness", fitness, {});
    v("early_stop", early_stop, {});
    v("validation", validation, {.help = "fresh jiggle seeds a scenario for the final choice", .min = 1, .max = 1000});
    v("log_rho_min", log_rho_min, {.help = "lower bound of log10 ρ", .min = -12, .max = 12});
    v("log_rho_max", log_rho_max, {.help = "upper bound of log10 ρ", .min = -12, .max = 12});
  }
  Status validate() const;
};

/// Where a study or an optimization stands.
struct Progress {
  std::string study;
  int round = 0;
  std::string stage;        ///< observe, collect, learn, optimize, execute, done
  std::string algorithm;    ///< with its restart where there are several: "cma 2"
  int done = 0, total = 0;  ///< evaluations, rollouts or scenarios of this stage
  double best_gamma = 0;    ///< of the samples of this algorithm and restart
  double mean_gamma = 0;    ///< of the present generation
  Rate success;             ///< optimize: over the scenarios of the best candidate so far; collect, execute: so far
  bool finished = false;
  std::string text;  ///< one sentence where there is more to say
};
using OnProgress = std::function<void(const Progress&)>;

/// Runs the goal: every algorithm and restart in turn, then the choice among their recommendations, their best samples
/// and P itself, by γ on the training set with fresh seeds. The evaluator's answers, the course and the choice are
/// journaled. A pure function of the goal.
Result<OptimizeResult> optimize(const OptimizeGoal& goal, Evaluator& evaluator, Journal& journal,
                                const OnProgress& on_progress = {});

/// The jiggle's seed: the same for all candidates of a generation, another for each scenario and generation.
std::uint64_t training_seed(const OptimizeGoal& goal, int generation, std::size_t scenario);
/// A seed of the validation, which no candidate has seen.
std::uint64_t validation_seed(std::uint64_t seed, int repetition, std::size_t scenario);

}  // namespace primo::study
