// P* = argmax γ(P) over the primitive's open entries, log10 ρ above all (paper, eq. 4): ask/tell optimizers on γ of
// Algorithm 1.
#pragma once

#include <functional>
#include <string>

#include "study/backend.h"
#include "study/journal.h"
#include "study/optimization_settings.h"

namespace primo::study {

/// Where a study or an optimization stands.
struct Progress {
  std::string study;
  std::string part;  ///< of the study
  int round = 0;
  std::string stage;        ///< observe, collect, learn, optimize, execute, generalize, done
  std::string algorithm;    ///< with its restart where there are several: "cma 2"
  int done = 0, total = 0;  ///< evaluations, rollouts or scenarios of this stage
  double best_gamma = 0;    ///< of the samples of this algorithm and restart
  double mean_gamma = 0;    ///< of the present generation
  double sigma = 0;         ///< of the search's distribution, fraction of the box's width; 0 where there is none
  double condition = 0;     ///< of its covariance
  Rate success;             ///< optimize: over the scenarios of the best candidate so far; collect, execute: so far
  bool finished = false;
  std::string text;  ///< one sentence where there is more to say
};
using OnProgress = std::function<void(const Progress&)>;

/// Runs the goal: every algorithm and restart in turn, then the choice among their recommendations, their best samples
/// and P itself, by γ on the training set with fresh seeds, or on the scenarios held out for it. The evaluator's
/// answers, the course and the choice are journaled. A pure function of the goal.
Result<OptimizeResult> optimize(const OptimizeGoal& goal, Evaluator& evaluator, Journal& journal,
                                const OnProgress& on_progress = {});

/// The jiggle's seed: the same for all candidates of a generation, another for each scenario and generation. Without
/// common random numbers each candidate has its own (`candidate` from 1 on).
std::uint64_t training_seed(const OptimizeGoal& goal, int generation, std::size_t scenario, std::size_t candidate = 0);
/// A seed of the validation, which no candidate has seen.
std::uint64_t validation_seed(std::uint64_t seed, int repetition, std::size_t scenario);

}  // namespace primo::study
