// What a rule set is worth on experiences: S(R) = log-likelihood − α · penalty.
#pragma once

#include <cstdint>

#include "rules/learner.h"
#include "rules/prediction.h"

namespace primo::rules {

struct Score {
  double log_likelihood = 0;    ///< Σ log P̂(s′|s,a), nats; an impossible experience counts log 1e-300
  std::int64_t penalty = 0;     ///< literals in contexts and outcomes
  std::int64_t impossible = 0;  ///< experiences to which the rules give probability 0
  double total(double alpha) const { return log_likelihood - alpha * static_cast<double>(penalty); }
};

/// Literals in the contexts and outcomes of all rules.
std::int64_t penalty(const RuleSet& rules);

/// P̂(s′|s,a) = p_min p_0 + Σ p_i [outcome i takes s to s′], with the probabilities that the rules state. An action
/// without a default rule is scored as if one said p(noise) = 1.
double likelihood(const Predictor& predictor, const symbols::Experience& experience, double p_min);

/// Of `rules` on `experiences`.
Score assess(const RuleSet& rules, const std::vector<symbols::Experience>& experiences, double p_min = 1e-8);

/// S(R), nats.
double score(const RuleSet& rules, const std::vector<symbols::Experience>& experiences,
             const LearnerSettings& settings = {});

}  // namespace primo::rules
