// The search operators: from one rule, or one example, to the rules that may take its place.
#pragma once

#include <set>
#include <vector>

#include "rules/action_examples.h"

namespace primo::rules {

/// Sets of rules, each of which may replace a rule.
using Replacements = std::set<std::vector<RuleKey>>;

/// ExplainExamples, first half: the most specific rule that an example suggests. Its context is every literal that
/// holds over the action's arguments, over those changed objects that the literals single out, and over constants.
RuleKey initial_rule(const Scene& scene, int max_references);

/// The most general start: of the same objects only the literals that the action makes false.
RuleKey changing_rule(const Scene& scene, int max_references);

/// ExplainExamples, second half: literals dropped one by one for as long as the score of {rule, default rule} grows.
RuleKey trimmed(ActionExamples& examples, RuleKey key);

/// Sets of rules, each of which may replace `key`, by all operators below. Sorted, no doubles.
std::vector<std::vector<RuleKey>> replacements(ActionExamples& examples, const RuleKey& key);

/// DropLits, DropRefs.
void drop(const RuleKey& key, Replacements& found);
/// AddLits and SplitOnLits: literals over the rule's variables and constants that hold in some covered example, their
/// negations, and both at once; for functions also ranges between two values, and one rule for each value.
void add_literals(ActionExamples& examples, const RuleKey& key, Replacements& found);
/// AddRefs: a new deictic variable together with one or two literals that speak of it, since one alone seldom singles
/// out an object.
void add_references(ActionExamples& examples, const RuleKey& key, Replacements& found);
/// GeneralizeEquality and ChangeRanges: f = n to f ≥ n or f ≤ n; a bound to another value that the data have.
void change_values(ActionExamples& examples, const RuleKey& key, Replacements& found);
/// RaiseConstants and SplitVariables: a constant to a variable; a variable to a constant it is, or to each.
void change_constants(ActionExamples& examples, const RuleKey& key, Replacements& found);

/// The literals that hold over bound objects and constants only, with the objects replaced by their variables. Sorted.
std::vector<LiftedLiteral> lifted_literals(const Scene& scene, const std::vector<std::int16_t>& bound);
bool mentions(const LiftedLiteral& literal, int variable);
/// The rule with these literals too, over so many variables, in canonical form.
RuleKey with(const RuleKey& key, std::initializer_list<LiftedLiteral> literals, int variables);
RuleKey without(const RuleKey& key, const LiftedLiteral& literal);

}  // namespace primo::rules
