#include "rules/search.h"

#include <algorithm>
#include <map>
#include <optional>
#include <set>

#include "rules/operators.h"

namespace primo::rules {
namespace {

constexpr double kImprovement = 1e-9;

/// Rules that cover no example twice, and their score.
struct Candidate {
  std::vector<RuleKey> rules;  // sorted
  double score = 0;

  /// By score; of equals the one that says more of what holds than of what does not; then in the order of rules, so
  /// that nothing depends on the order in which sets are found.
  bool better_than(const Candidate& other) const {
    if (score != other.score) return score > other.score;
    if (negations() != other.negations()) return negations() < other.negations();
    return rules < other.rules;
  }

 private:
  std::int64_t negations() const {
    std::int64_t sum = 0;
    for (const auto& key : rules) {
      sum += std::count_if(key.context.begin(), key.context.end(), [](const LiftedLiteral& l) { return l.negated; });
    }
    return sum;
  }
};

class Search {
 public:
  explicit Search(ActionExamples& examples) : examples_(examples) {
    for (const auto& scene : examples.scenes()) {
      initial_.push_back(initial_rule(scene, examples.settings().max_references));
    }
  }

  std::vector<RuleKey> run() {
    Candidate best = assess({});
    for (int step = 0; step < examples_.settings().max_steps; ++step) {
      const auto better = best_neighbour(best);
      if (!better) break;
      best = *better;
    }
    return best.rules;
  }

 private:
  Candidate assess(std::vector<RuleKey> rules) {
    std::sort(rules.begin(), rules.end());
    Candidate candidate;
    candidate.rules = std::move(rules);
    Bits covered(examples_.scenes().size());
    for (const auto& key : candidate.rules) {
      const auto& fitted = examples_.fit(key);
      covered |= fitted.covered;
      candidate.score += fitted.score;
    }
    double rest = 0;
    examples_.default_rule(covered, &rest);
    candidate.score += rest;
    return candidate;
  }

  /// The set with `added` in place of `removed`; rules that cover an example which a new one covers go. Nothing when a
  /// new rule is of no use.
  std::optional<Candidate> exchange(const std::vector<RuleKey>& rules, const RuleKey* removed,
                                    const std::vector<RuleKey>& added) {
    std::vector<RuleKey> next;
    for (const auto& key : added) {
      const auto& fitted = examples_.fit(key);
      if (!fitted.usable()) continue;  // a half of a split that covers nothing is left out
      const auto clash = [&](const RuleKey& other) { return examples_.fit(other).covered.intersects(fitted.covered); };
      if (std::any_of(next.begin(), next.end(), clash)) return std::nullopt;
      next.push_back(key);
    }
    if (!added.empty() && next.empty()) return std::nullopt;
    const std::size_t fresh = next.size();
    for (const auto& key : rules) {
      if (removed && key == *removed) continue;
      const auto clash = [&](std::size_t i) {
        return examples_.fit(next[i]).covered.intersects(examples_.fit(key).covered);
      };
      bool kept = true;
      for (std::size_t i = 0; i < fresh && kept; ++i) kept = !clash(i);
      if (kept) next.push_back(key);
    }
    return assess(std::move(next));
  }

  /// The best set one operator away, if it is better.
  std::optional<Candidate> best_neighbour(const Candidate& from) {
    std::optional<Candidate> best;
    const auto consider = [&](const std::optional<Candidate>& candidate) {
      if (!candidate || !(candidate->score > from.score + kImprovement)) return;
      if (!best || candidate->better_than(*best)) best = candidate;
    };
    for (const auto& key : explanations(from)) {
      if (exhausted()) break;
      consider(exchange(from.rules, nullptr, {key}));
    }
    for (const auto& key : from.rules) {
      consider(exchange(from.rules, &key, {}));
      for (const auto& added : replacements_of(key)) {
        if (exhausted()) break;
        consider(exchange(from.rules, &key, added));
      }
    }
    return best;
  }

  bool exhausted() const { return examples_.evaluations() >= examples_.settings().max_evaluations; }

  /// ExplainExamples for every example that only the default rule covers.
  std::set<RuleKey> explanations(const Candidate& from) {
    Bits covered(examples_.scenes().size());
    for (const auto& key : from.rules) covered |= examples_.fit(key).covered;
    std::set<RuleKey> initial, found;
    for (std::size_t i = 0; i < initial_.size(); ++i) {
      if (!covered.test(i)) initial.insert(initial_[i]);
    }
    for (const auto& key : initial) {
      if (exhausted()) break;
      auto at = trimmed_.find(key);
      if (at == trimmed_.end()) at = trimmed_.emplace(key, trimmed(examples_, key)).first;
      found.insert(at->second);
    }
    return found;
  }

  const std::vector<std::vector<RuleKey>>& replacements_of(const RuleKey& key) {
    const auto at = replacements_.find(key);
    if (at != replacements_.end()) return at->second;
    return replacements_.emplace(key, replacements(examples_, key)).first->second;
  }

  ActionExamples& examples_;
  std::vector<RuleKey> initial_;  // of each example
  std::map<RuleKey, RuleKey> trimmed_;
  std::map<RuleKey, std::vector<std::vector<RuleKey>>> replacements_;
};

}  // namespace

std::vector<RuleKey> search_rules(ActionExamples& examples) { return Search(examples).run(); }

}  // namespace primo::rules
