// The outcomes of a rule from the examples it covers: which sets of literals, with which probabilities.
#pragma once

#include <cstdint>
#include <vector>

#include "rules/coverage.h"
#include "rules/parameters.h"

namespace primo::rules {

using Outcome = std::vector<LiftedLiteral>;  ///< sorted

struct InducedOutcomes {
  std::vector<Outcome> outcomes;  ///< sorted; each with positive probability
  MixtureFit fit;
  std::vector<std::int64_t> counts;  ///< examples each explains
  std::int64_t noise_count = 0;      ///< examples none explains
  double score = 0;                  ///< log-likelihood − α · literals of all outcomes
};

/// Starts from every observed change that the variables can express and climbs the score by removing outcomes and by
/// merging two into their conjunction (finding the best set is NP-hard). The change of covered example i is
/// changes[numbers[i]]; number −1: the variables cannot express it. The result does not depend on the order of the
/// examples.
InducedOutcomes induce_outcomes(const std::vector<Scene>& scenes, const Covered& covered,
                                const std::vector<int>& numbers, const std::vector<const Outcome*>& changes,
                                double alpha, double p_min);

}  // namespace primo::rules
