// What a rule set does not know: entropy and noise of each rule, the experiences left to noise, and the literal that
// would split them best; and what changed from one rule set to the next.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "rules/learner.h"

namespace primo::rules {

/// −Σ p ln p over outcomes and noise, nats.
double entropy(const Rule& rule);

/// A literal over the rule's variables, and what splitting the rule by it would gain.
struct Split {
  symbols::Literal literal;
  double gain = 0;  ///< log-likelihood of two fits in place of one, nats
};

struct RuleDiagnosis {
  std::size_t rule = 0;  ///< index in the rule set
  double entropy = 0;    ///< nats
  double noise = 0;      ///< p_0
  std::int64_t covered = 0;
  std::vector<std::string> unexplained;  ///< ids (or "#" and the place) of covered experiences that no outcome explains
  std::optional<Split> split;  ///< the literal that separates them from the explained ones best; none: no gain
};

struct DefaultDiagnosis {
  std::string action;
  std::int64_t covered = 0;
  std::vector<std::string> unexplained;  ///< changed, but covered by no rule or by two
};

struct Diagnosis {
  std::vector<RuleDiagnosis> rules;
  std::vector<DefaultDiagnosis> defaults;
};

/// Of the rules on these experiences. The split separates explained from unexplained experiences: the gain is that of
/// the Bernoulli likelihood of "unexplained" when it may differ by the literal.
Diagnosis diagnose(const RuleSet& rules, const std::vector<symbols::Experience>& experiences);

/// Rules by their head (action and context as sets of literals).
struct Difference {
  std::vector<Rule> added, removed, changed;  ///< changed: as they are now; other outcomes or probabilities
  bool empty() const { return added.empty() && removed.empty() && changed.empty(); }
};
/// From one rule set to another. Probabilities that differ by no more than `tolerance` are the same.
Difference difference(const RuleSet& from, const RuleSet& to, double tolerance = 0);

}  // namespace primo::rules
