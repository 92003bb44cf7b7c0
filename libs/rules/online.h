// Learning an experience at a time. What was computed about rules is kept, and a rule's fit changes only when it covers
// the new experience.
#pragma once

#include <map>
#include <memory>
#include <set>
#include <string>

#include "rules/learner.h"
#include "rules/search.h"

namespace primo::rules {

class OnlineLearner {
 public:
  /// Error: as learn() has for settings and background.
  static Result<std::unique_ptr<OnlineLearner>> create(const LearnerSettings& settings = {},
                                                       const Background& background = {});

  struct Update {
    bool added = false;  ///< false: the experience was there already
    std::string action;
    bool contradicted = false;  ///< the rules said that this would not happen: they gave it to noise, or two cover it
  };
  /// Adds one. An action that it contradicts is relearned, by a search that starts from its present rules; otherwise
  /// the rules stand and their probabilities are fitted anew. Errors (data) as ExperienceStore::add().
  Result<Update> add(const symbols::Experience& experience, const std::string& where = "experience");

  /// Adds one without relearning anything before settle().
  Result<Update> note(const symbols::Experience& experience, const std::string& where = "experience");

  /// Searches the rules of every action that has new experiences since the last time, as if all of them had come at
  /// once: afterwards the rules are those of learn() on all experiences.
  void settle();

  const RuleSet& rules() const { return rules_; }
  /// S(R) of the rules on all experiences, nats.
  double score() const;
  std::int64_t experiences() const { return store_.size(); }

 private:
  struct Action {
    std::unique_ptr<ActionExamples> examples;
    std::unique_ptr<Search> search;
    std::vector<RuleKey> keys;
    RuleSet rules;  // of this action
    double score = 0;
    bool stale = true;  // has experiences that the last search from nothing did not see
  };

  OnlineLearner(const LearnerSettings& settings, const Background& background)
      : settings_(settings), store_(background) {}
  Action& action(const std::string& name);
  void fit(const std::string& name, Action& action);
  void publish();
  /// Orders the predicates; where that moves any, or another one turns out to change, all begins anew.
  void sort();

  LearnerSettings settings_;
  ExperienceStore store_;
  std::map<std::string, Action> actions_;
  RuleSet rules_;
};

}  // namespace primo::rules
