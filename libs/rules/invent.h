// Concept invention (Pasula, Zettlemoyer and Kaelbling 2007, section 5.3): derived predicates that make the rules score
// better are found and kept.
#pragma once

#include "rules/learner.h"

namespace primo::rules {

struct InventionSettings {
  double alpha = 1.0;     ///< nats that a concept in use costs, α′
  int rounds = 3;         ///< extensions of concepts by concepts
  int max_concepts = 60;  ///< candidates tried in a round
  template <class V>
  void visit(V&& v) {
    v("alpha", alpha, {.help = "what a concept in use costs", .unit = "nats", .min = 0, .max = 1e6});
    v("rounds", rounds, {.help = "extensions of concepts by concepts", .min = 1, .max = 10});
    v("max_concepts", max_concepts, {.help = "candidates tried in a round", .min = 1, .max = 1000});
  }
};

/// Rules with the background's and invented derived predicates: S′(R) = S(R) − α′ · (concepts in use). Each round
/// extends the primitive predicates and the concepts in use by exists, not exists, transitive closure and count, learns
/// anew, and stops when S′ does not grow. Invented names begin with "c-". Errors as learn().
Result<RuleSet> learn_inventing(const std::vector<symbols::Experience>& experiences,
                                const LearnerSettings& settings = {}, const Background& background = {},
                                const InventionSettings& invention = {});

}  // namespace primo::rules
