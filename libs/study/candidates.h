// γ of many primitives at once (paper, Algorithm 1): every one rolled out in the training scenarios.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "study/backend.h"
#include "study/journal.h"
#include "study/optimization_settings.h"

namespace primo::study {

/// γ of one primitive on a set of rollouts, and how often it succeeded there.
struct Score {
  double gamma = 0;  ///< the mean of g over these rollouts
  double rank = 0;   ///< what an optimizer is told: γ, but below all that went further where it was dropped
  int successes = 0;
  int final_pose = 0;
  int rollouts = 0;
  bool whole = true;  ///< went through all scenarios that were asked for
  bool succeeded_everywhere() const { return whole && successes == rollouts; }
};

/// The jiggle's seed of a candidate in a scenario.
using SeedOf = std::function<std::uint64_t(std::size_t candidate, std::size_t scenario)>;

class Candidates {
 public:
  /// The goal and the settings are kept by reference.
  Candidates(const OptimizeGoal& goal, const OptimizationSettings& settings, Evaluator& evaluator)
      : goal_(goal), settings_(settings), evaluator_(evaluator) {}

  /// Each primitive in these scenarios of the goal, once for each seed.
  Result<std::vector<Score>> evaluate(const std::vector<motion::Primitive>& primitives,
                                      const std::vector<std::size_t>& scenarios, const std::vector<SeedOf>& seeds);

  /// The same with one seed, where the settings want it as a race. `first`: which of the scenarios the race begins
  /// with, so that not the same few decide in every generation. The first `sure` primitives are never dropped.
  Result<std::vector<Score>> race(const std::vector<motion::Primitive>& primitives,
                                  const std::vector<std::size_t>& scenarios, const SeedOf& seed, std::size_t first,
                                  std::size_t sure = 0);

  /// The same with one seed, for who wants the best sample only: a scenario at a time, and no further with a primitive
  /// whose γ is below `to_beat` even if all that is left succeeds as well as can be. Its score is of what was rolled
  /// out, and below `to_beat`.
  Result<std::vector<Score>> contest(const std::vector<motion::Primitive>& primitives,
                                     const std::vector<std::size_t>& scenarios, const SeedOf& seed, double to_beat);

  std::int64_t rollouts() const { return rollouts_; }  ///< asked for so far

 private:
  struct Trial {
    std::size_t primitive = 0, scenario = 0;
    std::uint64_t seed = 0;
  };
  /// Adds the g of these trials to the sums in `scores`.
  Status add(const std::vector<motion::Primitive>& primitives, const std::vector<Trial>& trials,
             std::vector<Score>& sums);
  const OptimizeGoal& goal_;
  const OptimizationSettings& settings_;
  Evaluator& evaluator_;
  std::int64_t rollouts_ = 0;
};

}  // namespace primo::study
