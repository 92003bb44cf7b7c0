// The search over sets of rules for one action.
#pragma once

#include <vector>

#include "rules/fitted_rule.h"

namespace primo::rules {

/// A good set of rules by steepest ascent of S(R) from the default rule alone, with the operators ExplainExamples,
/// DropRules, DropLits, DropRefs, AddLits, SplitOnLits and AddRefs. No example is covered by two of them. Sorted.
std::vector<RuleKey> search_rules(ActionExamples& examples);

}  // namespace primo::rules
