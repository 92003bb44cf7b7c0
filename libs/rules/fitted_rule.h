// One action's examples, and the fit of any rule to them. Fits are remembered: the search asks for the same rules again
// and again.
#pragma once

#include <compare>
#include <cstdint>
#include <map>
#include <memory>
#include <vector>

#include "rules/bits.h"
#include "rules/grounding.h"
#include "rules/learner.h"
#include "rules/outcomes.h"

namespace primo::rules {

/// A rule without its outcomes: which variables the action's terms are, and the context. Variables beyond the action's
/// are deictic.
struct RuleKey {
  std::vector<std::int16_t> action;
  int variables = 0;
  std::vector<LiftedLiteral> context;
  auto operator<=>(const RuleKey&) const = default;

  int arguments() const { return count_arguments(action); }
  int references() const { return variables - arguments(); }
};

/// The same rule in the one form that all its renamings of deictic variables share: unused ones dropped, the context
/// sorted, numbered so that it comes first among all numberings.
RuleKey canonical(RuleKey key);

struct FittedRule {
  Bits covered;
  std::shared_ptr<const InducedOutcomes> induced;  ///< none when nothing is covered or nothing but noise is left
  double score = 0;                                ///< log-likelihood − α · (literals of context and outcomes)
  bool usable() const { return induced && !induced->outcomes.empty(); }
};

/// All examples of one action.
class ActionExamples {
 public:
  ActionExamples(std::vector<Scene> scenes, const LearnerSettings& settings);

  const std::vector<Scene>& scenes() const { return scenes_; }
  const LearnerSettings& settings() const { return settings_; }

  /// `key` must be canonical.
  const FittedRule& fit(const RuleKey& key);
  int evaluations() const { return static_cast<int>(fits_.size()); }

  /// The default rule over the examples outside `covered`, and its log-likelihood.
  DefaultRule default_rule(const Bits& covered, double* log_likelihood) const;

  /// The scene's binding, if the rule covers it.
  bool bind_scene(const RuleKey& key, std::size_t scene, std::vector<std::int16_t>& binding) const;

 private:
  const Bits& satisfied(const RuleKey& key, const LiftedLiteral& literal);

  std::vector<Scene> scenes_;
  LearnerSettings settings_;
  Bits all_, changed_;
  std::map<RuleKey, FittedRule> fits_;
  // Rules that cover the same examples with the same bindings share their outcomes.
  std::map<std::uint64_t, std::shared_ptr<const InducedOutcomes>> induced_;
  // Examples in which a literal over the action's arguments holds.
  std::map<std::pair<std::vector<std::int16_t>, LiftedLiteral>, Bits> satisfied_;
};

/// Which variable each term of the scene's action becomes: 0, 1, … in order, the same object the same variable.
std::vector<std::int16_t> action_terms(const Scene& scene);

}  // namespace primo::rules
