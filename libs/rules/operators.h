// The search operators: from one rule, or one example, to the rules that may take its place.
#pragma once

#include <vector>

#include "rules/fitted_rule.h"

namespace primo::rules {

/// ExplainExamples, first half: the most specific rule that an example suggests. Its context is every literal that
/// holds over the action's arguments and over those changed objects that the literals single out.
RuleKey initial_rule(const Scene& scene, int max_references);

/// ExplainExamples, second half: literals dropped one by one for as long as the score of {rule, default rule} grows.
RuleKey trimmed(ActionExamples& examples, RuleKey key);

/// Sets of rules, each of which may replace `key`: DropLits, DropRefs, AddLits, SplitOnLits and AddRefs. AddRefs brings
/// a new deictic variable together with one or two literals that speak of it, since one alone seldom singles out an
/// object. Sorted, no doubles.
std::vector<std::vector<RuleKey>> replacements(ActionExamples& examples, const RuleKey& key);

}  // namespace primo::rules
