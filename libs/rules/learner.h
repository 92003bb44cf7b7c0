// Learning NID rules from experiences: greedy search over rule sets for the score of Pasula, Zettlemoyer and Kaelbling,
// Learning Symbolic Models of Stochastic Domains, JAIR 29 (2007):
//   S(R) = Σ log P̂(s′|s,a,r(s,a)) − α Σ PEN(r),   P̂ = p_min p_0 + Σ p_i [outcome i takes s to s′],
// where PEN counts the literals of a rule's context and outcomes.
#pragma once

#include <vector>

#include "rules/experience_store.h"
#include "rules/rule.h"

namespace primo::rules {

struct LearnerSettings {
  double alpha = 0.5;            ///< nats a literal costs
  double p_min = 1e-8;           ///< probability a noise outcome gives to a state
  double caution = 3;            ///< nats that each rule must earn beyond its literals (decision 0304)
  double requirement = 1;        ///< nats that a context literal earns which is surely made false (decision 0307)
  double negation = 2;           ///< nats that a negated context literal costs that no split has made (decision 0308)
  double term = 0.1;             ///< nats that each term of a context literal costs beside alpha (decision 0308)
  double guess = 3;              ///< nats that a property costs which actions change, but not this one (decision 0309)
  int max_references = 3;        ///< deictic variables a rule
  int max_steps = 10000;         ///< accepted changes of the rule set, for each action
  int max_candidates = 1000000;  ///< sets of rules looked at, for each action; then the best so far is returned
  int look_ahead = 20;           ///< worse neighbours of a local optimum from which the search goes on
  template <class V>
  void visit(V&& v) {
    v("alpha", alpha, {.help = "penalty of a literal", .unit = "nats", .min = 0, .max = 1e6});
    v("p_min", p_min, {.help = "probability that noise gives to a state", .min = 1e-300, .max = 0.1});
    v("caution", caution, {.help = "what a rule must earn beyond its literals", .unit = "nats", .min = 0, .max = 1e6});
    v("requirement", requirement,
      {.help = "what a context literal earns that outcomes make false, times their probability; thrice that costs a "
               "literal they make false that is not in the context",
       .unit = "nats",
       .min = 0,
       .max = 1e6});
    v("negation", negation,
      {.help = "cost of a negated context literal that no other rule has unnegated",
       .unit = "nats",
       .min = 0,
       .max = 1e6});
    v("term", term, {.help = "cost of each term of a context literal", .unit = "nats", .min = 0, .max = 1e6});
    v("guess", guess,
      {.help = "cost of a context literal of one object or none that some action changes and this one does not undo",
       .unit = "nats",
       .min = 0,
       .max = 1e6});
    v("max_references", max_references, {.help = "deictic variables a rule", .min = 0, .max = 6});
    v("max_steps", max_steps, {.help = "accepted changes of the rule set for each action", .min = 1, .max = 1e9});
    v("max_candidates", max_candidates, {.help = "sets of rules looked at for each action", .min = 1, .max = 1e9});
    v("look_ahead", look_ahead,
      {.help = "worse neighbours of a local optimum from which the search goes on", .min = 0, .max = 1e4});
  }
};

/// The rules of every action in `experiences`. They do not depend on the order of the experiences or on the names of
/// objects (other than the background's constants). Experiences with the same non-empty id count once. No experiences:
/// no rules. Errors (data): an ill-formed experience, one id with two contents, a predicate with two arities, a
/// definition that uses a later one; settings out of range (config).
Result<RuleSet> learn(const std::vector<symbols::Experience>& experiences, const LearnerSettings& settings = {},
                      const Background& background = {});
/// The same of a store, whose predicates are sorted.
Result<RuleSet> learn(ExperienceStore& store, const LearnerSettings& settings = {});

/// The positive literals over the rule's variables that held in every experience the rule covers and are not in its
/// context. The data say nothing about what happens without them, so the learner leaves them out; a printed rule may
/// list them beside.
std::vector<symbols::Literal> untested_context(const Rule& rule, const std::vector<symbols::Experience>& experiences);

class ActionExamples;
struct RuleKey;
/// Adds the action's rules and its default rule to `rules`, with their parameters; their S(R).
double add_rules(const ExperienceStore& store, const std::string& action, ActionExamples& examples,
                 const std::vector<RuleKey>& keys, RuleSet& rules);
/// Error (config): a setting is out of its range.
Status check(const LearnerSettings& settings);

}  // namespace primo::rules
