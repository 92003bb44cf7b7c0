// Noisy indeterministic deictic rules (Pasula, Zettlemoyer, Kaelbling, JAIR 2007).
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "symbols/literal.h"

namespace primo::rules {

/// With probability p the literals become true (negated ones: false); everything else persists.
struct RuleOutcome {
  double p = 0;
  std::vector<symbols::Literal> literals;
  std::int64_t count = 0;  ///< training examples this outcome explains
};

/// action(X…) : context → outcomes | noise. Variables begin with a capital; those not among the action's arguments are deictic
/// and must bind uniquely. Distinct variables denote distinct objects.
struct Rule {
  symbols::Literal action;
  std::vector<symbols::Literal> context;
  std::vector<RuleOutcome> outcomes;
  double noise = 0;
  std::int64_t noise_count = 0;
};

struct DefaultRule {
  double no_change = 0;
  double noise = 0;
  std::int64_t no_change_count = 0, noise_count = 0;
};

struct RuleSet {
  std::vector<Rule> rules;
  std::map<std::string, DefaultRule> defaults;  ///< by action name
};

/// The JSON form of the design page, and back. Errors name what is wrong and where.
std::string to_json(const RuleSet& rules);
Result<RuleSet> rules_from_json(const std::string& text);

/// The paper's layout: "grasp(X): on(X,Y), … → { 0.94: inhand(X), ¬on(X,Y) | 0.06: noise }" on several lines.
std::string to_text(const Rule& rule);
std::string to_text(const RuleSet& rules);

/// The paper's simplification: the most probable outcome is the desired one, all else is noise (eq. 3).
Rule project_to_desired(const Rule& rule);

}  // namespace primo::rules
