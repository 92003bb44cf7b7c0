// Noisy indeterministic deictic rules (Pasula, Zettlemoyer, Kaelbling, JAIR 2007).
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "symbols/derived.h"
#include "symbols/literal.h"

namespace primo::rules {

/// With probability p the literals become true (negated ones: false); everything else persists.
struct RuleOutcome {
  double p = 0;
  std::vector<symbols::Literal> literals;
  std::int64_t count = 0;  ///< training examples this outcome explains
};

/// action(X…) : context → outcomes | noise. Variables begin with a capital; those not among the action's arguments are
/// deictic and must bind uniquely. Distinct variables denote distinct objects.
struct Rule {
  symbols::Literal action;
  std::vector<symbols::Literal> context;
  std::vector<RuleOutcome> outcomes;
  double noise = 0;
  std::int64_t noise_count = 0;  ///< training examples that no outcome explains
  /// Training examples the rule covers: Σ counts + noise_count, or less when an example is explained by several
  /// outcomes. 0: not known, take the sum (see trials()).
  std::int64_t examples = 0;

  std::int64_t trials() const;  ///< examples, or the sum of all counts when that is not stated
};

struct DefaultRule {
  double no_change = 0;
  double noise = 0;
  std::int64_t no_change_count = 0, noise_count = 0;
};

struct RuleSet {
  std::vector<Rule> rules;
  std::map<std::string, DefaultRule> defaults;  ///< by action name
  std::vector<symbols::Definition> derived;     ///< what contexts use beside the state
};

/// The JSON form of the design page, and back. Errors name what is wrong and where.
std::string to_json(const RuleSet& rules);
Result<RuleSet> rules_from_json(const std::string& text);

/// The paper's layout: "grasp(X): on(X,Y), … → { 0.94: inhand(X), ¬on(X,Y) | 0.06: noise }" on several lines.
std::string to_text(const Rule& rule);
std::string to_text(const RuleSet& rules);

/// The index of the most probable outcome that changes anything (has a literal); −1 when there is none. See decision
/// 0301.
int desired_index(const Rule& rule);

/// The paper's simplification: the most probable outcome that changes anything is the desired one, all else is noise
/// (eq. 3). With counts, the probabilities are those of the maximum likelihood: count / trials.
Rule project_to_desired(const Rule& rule);

}  // namespace primo::rules
