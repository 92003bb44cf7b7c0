// The outcomes of a rule from the examples it covers: which sets of literals, with which probabilities.
#pragma once

#include <cstdint>
#include <vector>

#include "rules/grounding.h"
#include "rules/parameters.h"

namespace primo::rules {

using Outcome = std::vector<LiftedLiteral>;  ///< sorted

/// A covered example as seen through the rule's variables.
struct EffectCase {
  const Scene* scene = nullptr;
  std::vector<std::int16_t> binding;  ///< variable → object
};

struct InducedOutcomes {
  std::vector<Outcome> outcomes;  ///< sorted; each with positive probability
  MixtureFit fit;
  std::vector<std::int64_t> counts;  ///< examples each explains
  std::int64_t noise_count = 0;      ///< examples none explains
  double score = 0;                  ///< log-likelihood − α · literals of all outcomes
};

/// Starts from every observed change that the variables can express and climbs the score by removing outcomes and by
/// merging two into their conjunction (finding the best set is NP-hard). The result does not depend on the order of the
/// cases.
InducedOutcomes induce_outcomes(const std::vector<EffectCase>& cases, double alpha, double p_min);

}  // namespace primo::rules
