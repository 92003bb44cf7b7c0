#include "rules/online.h"

#include <algorithm>

#include "rules/prediction.h"

namespace primo::rules {
namespace {

/// Whether one rule's outcome, or the default rule's "no change", is what happened.
bool described(const RuleSet& rules, const symbols::Experience& experience) {
  const auto prediction = predict(rules, experience.objects, experience.before, experience.action);
  return std::any_of(prediction.successors.begin(), prediction.successors.end(),
                     [&](const Successor& successor) { return successor.state == experience.after; });
}

}  // namespace

Result<std::unique_ptr<OnlineLearner>> OnlineLearner::create(const LearnerSettings& settings,
                                                             const Background& background) {
  PRIMO_TRY(check(settings));
  PRIMO_TRY(symbols::check_order(background.derived));
  std::unique_ptr<OnlineLearner> learner(new OnlineLearner(settings, background));
  learner->rules_.derived = background.derived;
  return learner;
}

OnlineLearner::Action& OnlineLearner::action(const std::string& name) {
  Action& action = actions_[name];
  if (!action.examples) {
    action.examples = std::make_unique<ActionExamples>(store_.scenes().at(name), store_.changing(), settings_);
    action.search = std::make_unique<Search>(*action.examples);
  }
  return action;
}

void OnlineLearner::fit(const std::string& name, Action& action) {
  action.rules = {};
  action.rules.derived = store_.background().derived;
  action.score = add_rules(store_, name, *action.examples, action.keys, action.rules);
}

void OnlineLearner::publish() {
  rules_.rules.clear();
  for (const auto& [name, action] : actions_) {
    rules_.rules.insert(rules_.rules.end(), action.rules.rules.begin(), action.rules.rules.end());
    if (action.rules.defaults.contains(name)) rules_.defaults[name] = action.rules.defaults.at(name);
  }
}

void OnlineLearner::sort() {
  if (store_.sort()) actions_.clear();
  for (const auto& [name, scenes] : store_.scenes()) action(name);
}

Result<OnlineLearner::Update> OnlineLearner::note(const symbols::Experience& experience, const std::string& where) {
  Update update{.added = false, .action = experience.action.predicate};
  PRIMO_ASSIGN(update.added, store_.add(experience, where));
  if (!update.added) return update;
  update.contradicted = !described(rules_, experience);
  action(update.action).stale = true;
  return update;
}

Result<OnlineLearner::Update> OnlineLearner::add(const symbols::Experience& experience, const std::string& where) {
  PRIMO_ASSIGN(Update update, note(experience, where));
  if (!update.added) return update;
  sort();
  for (auto& [name, action] : actions_) {
    const bool begins_anew = action.rules.defaults.empty();
    if (name != update.action && !begins_anew) continue;
    if (update.contradicted || begins_anew) action.keys = action.search->climb(action.keys).rules;
    fit(name, action);
  }
  publish();
  return update;
}

void OnlineLearner::settle() {
  sort();
  for (auto& [name, action] : actions_) {
    if (!action.stale) continue;
    action.keys = action.search->climb({}).rules;
    fit(name, action);
    action.stale = false;
  }
  publish();
}

double OnlineLearner::score() const {
  double sum = 0;
  for (const auto& [name, action] : actions_) sum += action.score;
  return sum;
}

}  // namespace primo::rules
