// One action's examples, and the fit of any rule to them. Fits are remembered: the search asks for the same rules again
// and again. Examples may be added; a remembered fit then changes only if its rule covers a new one.
#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <set>
#include <unordered_map>
#include <vector>

#include "rules/bits.h"
#include "rules/coverage.h"
#include "rules/learner.h"
#include "rules/outcomes.h"
#include "rules/rule_key.h"

namespace primo::rules {

struct FittedRule {
  Bits covered;
  std::shared_ptr<const InducedOutcomes> induced;  ///< none when nothing is covered
  /// Log-likelihood − α · (literals of context and outcomes) + requirement · (literals that are made false, each by its
  /// probability; those that the context does not have count −3) − negation · (negated literals of the context)
  /// − term · (its terms) − guess · (its literals that are a guess; less each where many examples are covered).
  double score = 0;
  std::size_t seen = 0;  ///< examples this is the fit to
  bool usable() const { return induced && !induced->outcomes.empty(); }
};

class ActionExamples {
 public:
  /// Both must outlive this; scenes may become more, but those that are there must not change. `changing`: the
  /// predicates that any action changes.
  ActionExamples(const std::vector<Scene>& scenes, const std::set<std::int16_t>& changing,
                 const LearnerSettings& settings)
      : scenes_(scenes), changing_(changing), settings_(settings), coverage_(scenes) {}
  ActionExamples(const ActionExamples&) = delete;
  ActionExamples& operator=(const ActionExamples&) = delete;

  const std::vector<Scene>& scenes() const { return scenes_; }
  const LearnerSettings& settings() const { return settings_; }

  /// `key` must be canonical. The answer stays valid until limit_memory().
  const FittedRule& fit(const RuleKey& key);
  /// The examples that the rule covers, with their bindings.
  Covered cover(const RuleKey& key) { return coverage_.cover(key); }

  /// The default rule over the examples outside `covered`, and its log-likelihood.
  DefaultRule default_rule(const Bits& covered, double* log_likelihood);
  /// Examples without any change.
  const Bits& unchanged() { return extend(), unchanged_; }

  /// Lets go of remembered fits when they have become many.
  void limit_memory();

 private:
  void extend();
  void refit(const RuleKey& key, FittedRule& fitted);
  /// The number of the example's change as the rule's variables say it; −1: they cannot.
  int change(const Covered& covered, std::size_t i);

  const std::vector<Scene>& scenes_;
  const std::set<std::int16_t>& changing_;
  LearnerSettings settings_;
  Coverage coverage_;
  Bits all_, unchanged_;
  std::unordered_map<RuleKey, FittedRule, RuleKeyHash> fits_;
  // Rules that cover the same examples and say the same of their changes share their outcomes.
  std::unordered_map<std::uint64_t, std::shared_ptr<const InducedOutcomes>> induced_;
  // Changes over variables, numbered; and for each example which number its objects' variables make of it.
  std::map<Outcome, int> numbers_;
  std::vector<const Outcome*> changes_;
  std::vector<std::vector<std::pair<std::uint64_t, int>>> known_changes_;
  std::vector<std::vector<std::int16_t>> changed_objects_;
};

}  // namespace primo::rules
