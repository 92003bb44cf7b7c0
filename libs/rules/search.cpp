#include "rules/search.h"

#include <algorithm>

#include "rules/operators.h"

namespace primo::rules {
namespace {

constexpr double kImprovement = 1e-9;

/// The negated context literals that another rule has unnegated: a split made them, and they are no guess. `active`:
/// the rules that change something, as others would be there for no other reason.
std::int64_t split_negations(const std::vector<RuleKey>& rules, const std::vector<const RuleKey*>& active) {
  const auto held = [&](LiftedLiteral literal) {
    if (!literal.negated) return false;
    literal.negated = false;
    return std::any_of(active.begin(), active.end(), [&](const RuleKey* rule) {
      return std::binary_search(rule->context.begin(), rule->context.end(), literal);
    });
  };
  std::int64_t sum = 0;
  for (const auto& key : rules) sum += std::count_if(key.context.begin(), key.context.end(), held);
  return sum;
}

bool changes_something(const FittedRule& rule) {
  return std::any_of(rule.induced->outcomes.begin(), rule.induced->outcomes.end(),
                     [](const Outcome& outcome) { return !outcome.empty(); });
}

}  // namespace

struct Search::Candidate : ScoredRules {
  Bits covered;
  std::int64_t noise = 0;  ///< changed examples that the default rule has

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

ScoredRules Search::climb(const std::vector<RuleKey>& from) {
  candidates_ = 0;
  for (std::size_t i = initial_.size(); i < examples_.scenes().size(); ++i) {
    initial_.push_back(initial_rule(examples_.scenes()[i], examples_.settings().max_references));
    general_.push_back(changing_rule(examples_.scenes()[i], examples_.settings().max_references));
  }
  Candidate best = exchange({}, nullptr, {}).value();
  for (const auto& key : from) {
    if (examples_.fit(key).usable()) {
      if (auto added = exchange(best.rules, nullptr, {key}); added && added->rules.size() > best.rules.size()) {
        best = std::move(*added);
      }
    }
  }
  return without_idle_rules(look_ahead(ascend(std::move(best))));
}

/// Without the rules that say no more than the default rule does.
Search::Candidate Search::without_idle_rules(Candidate best) {
  const auto rules = best.rules;
  for (const auto& key : rules) {
    auto fewer = exchange(best.rules, &key, {});
    if (fewer && fewer->score >= best.score - kImprovement) best = std::move(*fewer);
  }
  return best;
}

Search::Candidate Search::ascend(Candidate best) {
  for (int step = 0; step < examples_.settings().max_steps; ++step) {
    examples_.limit_memory();
    auto better = best_neighbour(best, false);
    if (!better) better = best_neighbour(best, true);
    if (!better && best.noise > 0) better = explained_beside(best);
    if (!better) break;
    best = std::move(*better);
  }
  return best;
}

/// Goes on from a set that no single operator improves: from its best neighbours, though they are worse, since some
/// improvements take two operators of which the first alone does not pay.
Search::Candidate Search::look_ahead(Candidate best) {
  for (bool improved = true; improved && !exhausted();) {
    improved = false;
    const double reached = best.score + kImprovement;
    for (const auto& start : promising(best)) {
      if (exhausted()) break;
      examples_.limit_memory();
      auto summit = summit_from(start, best);
      if (!(summit.score > reached) || !summit.better_than(best)) continue;
      best = std::move(summit);
      improved = true;
    }
  }
  return best;
}

/// Where the ascent from a worse neighbour ends. One that leaves changed examples of a rule to the default rule often
/// leads straight back, since a rule for them that is trimmed alone takes in the others again: then they are explained
/// beside the rest.
Search::Candidate Search::summit_from(const Candidate& start, const Candidate& best) {
  auto summit = ascend(start);
  const double reached = best.score + kImprovement;
  if (summit.score > reached || start.noise <= best.noise) return summit;
  auto beside = explained_beside(start);
  return beside && beside->score > reached ? ascend(std::move(*beside)) : summit;
}

/// The best of all neighbours, of those that cover and explain the same examples alike only the best.
std::vector<Search::Candidate> Search::promising(const Candidate& from) {
  std::map<std::set<const InducedOutcomes*>, Candidate> kinds;
  const auto kind = [&](const Candidate& candidate) {
    std::set<const InducedOutcomes*> fits;
    for (const auto& key : candidate.rules) fits.insert(examples_.fit(key).induced.get());
    return fits;
  };
  const auto own = kind(from);
  for_each_neighbour(from, [&](Candidate&& candidate) {
    auto fits = kind(candidate);
    if (fits == own) return;
    const auto [at, fresh] = kinds.try_emplace(std::move(fits), candidate);
    if (!fresh && candidate.better_than(at->second)) at->second = std::move(candidate);
  });
  std::vector<Candidate> best;
  best.reserve(kinds.size());
  for (auto& [fits, candidate] : kinds) best.push_back(std::move(candidate));
  std::sort(best.begin(), best.end(), [](const Candidate& a, const Candidate& b) { return a.better_than(b); });
  const auto width = static_cast<std::size_t>(examples_.settings().look_ahead);
  if (best.size() > width) best.resize(width);
  return best;
}

void Search::for_each_neighbour(const Candidate& from, const std::function<void(Candidate&&)>& visit) {
  const auto consider = [&](std::optional<Candidate> candidate) {
    if (candidate) visit(std::move(*candidate));
  };
  for (const auto& key : from.rules) {
    consider(exchange(from.rules, &key, {}));
    for (const auto& added : replacements_of(key)) {
      if (exhausted()) return;
      consider(exchange(from.rules, &key, added));
    }
  }
}

Search::Candidate Search::assess(std::vector<RuleKey> rules) {
  std::sort(rules.begin(), rules.end());
  ++candidates_;
  Candidate candidate;
  candidate.rules = std::move(rules);
  candidate.covered = Bits(examples_.scenes().size());
  std::vector<const RuleKey*> active;
  for (const auto& key : candidate.rules) {
    const auto& fitted = examples_.fit(key);
    candidate.covered |= fitted.covered;
    candidate.score += fitted.score - examples_.settings().caution;
    if (changes_something(fitted)) active.push_back(&key);
  }
  candidate.score += examples_.settings().negation * static_cast<double>(split_negations(candidate.rules, active));
  double rest = 0;
  candidate.noise = examples_.default_rule(candidate.covered, &rest).noise_count;
  candidate.score += rest;
  return candidate;
}

/// The set with `added` in place of `removed`; rules that cover an example which a new one covers go. Nothing when a
/// new rule is of no use.
std::optional<Search::Candidate> Search::exchange(const std::vector<RuleKey>& rules, const RuleKey* removed,
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
std::optional<Search::Candidate> Search::best_neighbour(const Candidate& from, bool thorough) {
  std::optional<Candidate> best;
  const auto consider = [&](Candidate&& candidate) {
    if (!(candidate.score > from.score + kImprovement)) return;
    if (!best || candidate.better_than(*best)) best = std::move(candidate);
  };
  for (const auto& key : explanations(from, thorough)) {
    if (exhausted()) break;
    if (auto candidate = exchange(from.rules, nullptr, {key})) consider(std::move(*candidate));
  }
  if (!thorough) for_each_neighbour(from, consider);  // when thorough, they were not better
  return best;
}

/// ExplainExamples for the examples that only the default rule covers. Examples that a rule found for others explains
/// are passed over unless `thorough`: their own rules would most likely be the same.
std::set<RuleKey> Search::explanations(const Candidate& from, bool thorough) {
  // In an order that knows no example's number.
  std::map<RuleKey, std::vector<std::size_t>> initial;
  bool all_explained = true;
  for (std::size_t i = 0; i < initial_.size(); ++i) {
    if (from.covered.test(i)) continue;
    initial[initial_[i]].push_back(i);
    all_explained = all_explained && examples_.unchanged().test(i);
  }
  std::set<RuleKey> found;
  if (all_explained) return found;  // the default rule is certain of them
  for (std::size_t i = 0; i < general_.size(); ++i) {
    if (!from.covered.test(i) && !examples_.unchanged().test(i)) found.insert(general_[i]);
  }
  Bits explained = examples_.unchanged();
  for (const auto& [key, members] : initial) {
    if (exhausted()) break;
    const auto known = [&](std::size_t i) { return explained.test(i); };
    if (!thorough && std::all_of(members.begin(), members.end(), known)) continue;
    const RuleKey& rule = trimmed_rule(key);
    if (!found.insert(rule).second) continue;
    const auto& fitted = examples_.fit(rule);
    if (fitted.usable() && fitted.induced->noise_count == 0) explained |= fitted.covered;
  }
  return found;
}

/// ExplainExamples for the changed examples that only the default rule covers, each trimmed for what it adds to these
/// rules: trimmed alone, a rule grows over examples that others have, and cannot join them.
std::optional<Search::Candidate> Search::explained_beside(const Candidate& from) {
  std::set<RuleKey> specific;
  for (std::size_t i = 0; i < initial_.size(); ++i) {
    if (!from.covered.test(i) && !examples_.unchanged().test(i)) specific.insert(initial_[i]);
  }
  std::optional<Candidate> best;
  for (RuleKey key : specific) {
    std::optional<Candidate> reached = exchange(from.rules, nullptr, {key});
    for (bool shorter = true; shorter && reached && !exhausted();) {
      shorter = false;
      Replacements fewer;
      drop(key, fewer);
      for (const auto& candidate : fewer) {
        auto next = exchange(from.rules, nullptr, candidate);
        if (!next || !(next->score > reached->score + kImprovement)) continue;
        reached = std::move(next);
        key = candidate.front();
        shorter = true;
      }
    }
    if (!reached || !(reached->score > from.score + kImprovement)) continue;
    if (!best || reached->better_than(*best)) best = std::move(reached);
  }
  return best;
}

const RuleKey& Search::trimmed_rule(const RuleKey& initial) {
  auto& [rule, examples] = trimmed_[initial];
  if (examples != examples_.scenes().size()) {
    rule = trimmed(examples_, initial);
    examples = examples_.scenes().size();
  }
  return rule;
}

const std::vector<std::vector<RuleKey>>& Search::replacements_of(const RuleKey& key) {
  auto& remembered = replacements_[key];
  const std::int64_t covered = examples_.fit(key).covered.count();
  // The bounds tried for a function are those of all examples.
  const bool ranges = std::any_of(key.context.begin(), key.context.end(),
                                  [](const LiftedLiteral& literal) { return literal.relation != Relation::none; });
  const std::size_t examples = examples_.scenes().size();
  if (remembered.covered != covered || (ranges && remembered.examples != examples)) {
    remembered = {replacements(examples_, key), covered, examples};
  }
  return remembered.rules;
}

}  // namespace primo::rules
