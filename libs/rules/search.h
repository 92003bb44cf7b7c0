// The search over sets of rules for one action.
#pragma once

#include <functional>
#include <map>
#include <optional>
#include <set>
#include <vector>

#include "rules/action_examples.h"

namespace primo::rules {

/// Rules that cover no example twice, and their score with the default rule's.
struct ScoredRules {
  std::vector<RuleKey> rules;  ///< sorted
  double score = 0;
};

class Search {
 public:
  explicit Search(ActionExamples& examples) : examples_(examples) {}

  /// Steepest ascent of S(R) from these rules (those that cover an example which one before them covers are left out),
  /// with the operators ExplainExamples, DropRules, DropLits, DropRefs, AddLits, SplitOnLits, AddRefs,
  /// GeneralizeEquality, ChangeRanges, RaiseConstants and SplitVariables. May be called again when there are more
  /// examples; what is known of rules is kept.
  ScoredRules climb(const std::vector<RuleKey>& from);

 private:
  struct Candidate;
  Candidate ascend(Candidate best);
  Candidate look_ahead(Candidate best);
  Candidate summit_from(const Candidate& start, const Candidate& best);
  Candidate without_idle_rules(Candidate best);
  std::vector<Candidate> promising(const Candidate& from);
  void for_each_neighbour(const Candidate& from, const std::function<void(Candidate&&)>& visit);
  Candidate assess(std::vector<RuleKey> rules);
  std::optional<Candidate> exchange(const std::vector<RuleKey>& rules, const RuleKey* removed,
                                    const std::vector<RuleKey>& added);
  std::optional<Candidate> best_neighbour(const Candidate& from, bool thorough);
  std::optional<Candidate> explained_beside(const Candidate& from);
  std::set<RuleKey> explanations(const Candidate& from, bool thorough);
  const RuleKey& trimmed_rule(const RuleKey& initial);
  const std::vector<std::vector<RuleKey>>& replacements_of(const RuleKey& key);
  bool exhausted() const { return candidates_ >= examples_.settings().max_candidates; }

  ActionExamples& examples_;
  std::int64_t candidates_ = 0;             // looked at in this climb
  std::vector<RuleKey> initial_, general_;  // most specific and most general rule of each example
  struct Remembered {
    std::vector<std::vector<RuleKey>> rules;
    std::int64_t covered = -1;  // examples covered when they were found
    std::size_t examples = 0;   // and all
  };
  std::map<RuleKey, Remembered> replacements_;
  std::map<RuleKey, std::pair<RuleKey, std::size_t>> trimmed_;  // and the number of examples it was trimmed with
};

}  // namespace primo::rules
