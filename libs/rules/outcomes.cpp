#include "rules/outcomes.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>

#include "rules/bits.h"

namespace primo::rules {
namespace {

constexpr double kImprovement = 1e-9;

/// The change of a case over the rule's variables; empty when an object that changes is not bound.
std::optional<Outcome> lifted_change(const EffectCase& example) {
  Outcome change = example.scene->changes;
  for (auto& literal : change) {
    for (std::size_t i = 1; i < literal.atom.size() && literal.atom[i] != -1; ++i) {
      const auto at = std::find(example.binding.begin(), example.binding.end(), literal.atom[i]);
      if (at == example.binding.end()) return std::nullopt;
      literal.atom[i] = static_cast<std::int16_t>(at - example.binding.begin());
    }
  }
  std::sort(change.begin(), change.end());
  return change;
}

/// A and B, or nothing when they contradict each other.
std::optional<Outcome> conjunction(const Outcome& a, const Outcome& b) {
  Outcome both;
  std::set_union(a.begin(), a.end(), b.begin(), b.end(), std::back_inserter(both));
  for (std::size_t i = 1; i < both.size(); ++i) {
    if (both[i].atom == both[i - 1].atom) return std::nullopt;
  }
  return both;
}

class Inducer {
 public:
  Inducer(const std::vector<EffectCase>& cases, double alpha, double p_min)
      : cases_(cases), alpha_(alpha), p_min_(p_min) {
    for (std::size_t i = 0; i < cases.size(); ++i) {
      if (auto change = lifted_change(cases[i])) groups_[*change].push_back(i);
    }
  }

  InducedOutcomes run() {
    std::vector<Outcome> observed;
    for (const auto& [change, members] : groups_) observed.push_back(change);
    InducedOutcomes best = evaluate(observed);
    for (;;) {
      std::optional<InducedOutcomes> better;
      double threshold = best.score + kImprovement;
      for (const auto& candidate : neighbours(best.outcomes)) {
        auto evaluated = evaluate(candidate);
        if (evaluated.score <= threshold) continue;
        threshold = evaluated.score;
        better = std::move(evaluated);
      }
      if (!better) return best;
      best = std::move(*better);
    }
  }

 private:
  /// The cases that an outcome takes from s to s′: every change is in it, and all of it holds afterwards.
  const Bits& explained(const Outcome& outcome) {
    const auto [at, fresh] = explained_.try_emplace(outcome, cases_.size());
    if (!fresh) return at->second;
    for (const auto& [change, members] : groups_) {
      if (!std::includes(outcome.begin(), outcome.end(), change.begin(), change.end())) continue;
      Outcome rest;
      std::set_difference(outcome.begin(), outcome.end(), change.begin(), change.end(), std::back_inserter(rest));
      for (const auto i : members) {
        const bool holds = std::all_of(rest.begin(), rest.end(), [&](const LiftedLiteral& literal) {
          return contains(cases_[i].scene->after, instantiate(literal.atom, cases_[i].binding)) != literal.negated;
        });
        if (holds) at->second.set(i);
      }
    }
    return at->second;
  }

  std::vector<MixtureCell> cells(const std::vector<Outcome>& outcomes) {
    std::map<std::vector<int>, double> weights;
    std::vector<std::vector<int>> explanations(cases_.size());
    for (std::size_t o = 0; o < outcomes.size(); ++o) {
      const Bits& bits = explained(outcomes[o]);
      for (std::size_t i = 0; i < cases_.size(); ++i) {
        if (bits.test(i)) explanations[i].push_back(static_cast<int>(o));
      }
    }
    for (const auto& explanation : explanations) ++weights[explanation];
    std::vector<MixtureCell> cells;
    for (const auto& [explanation, weight] : weights) cells.push_back({explanation, weight});
    return cells;
  }

  InducedOutcomes evaluate(const std::vector<Outcome>& outcomes) {
    InducedOutcomes induced;
    auto fit = fit_outcomes(cells(outcomes), static_cast<int>(outcomes.size()), p_min_);
    Bits any(cases_.size());
    std::size_t literals = 0;
    for (std::size_t o = 0; o < outcomes.size(); ++o) {
      if (!(fit.p[o] > 0)) continue;
      induced.outcomes.push_back(outcomes[o]);
      induced.fit.p.push_back(fit.p[o]);
      induced.counts.push_back(explained(outcomes[o]).count());
      any |= explained(outcomes[o]);
      literals += outcomes[o].size();
    }
    induced.noise_count = static_cast<std::int64_t>(cases_.size()) - any.count();
    induced.fit.noise = fit.noise;
    induced.fit.log_likelihood = fit.log_likelihood;
    induced.fit.gap = fit.gap;
    induced.fit.iterations = fit.iterations;
    induced.score = fit.log_likelihood - alpha_ * static_cast<double>(literals);
    return induced;
  }

  /// Whether dropping the outcome can pay at all. Its m own examples fall to noise, and the others' likelihood can rise
  /// by no more than the entropy N·H(m/N) ≤ m (1 + ln N/m), since the present fit is optimal.
  bool may_go(const std::vector<Outcome>& outcomes, const Outcome& outcome) {
    Bits own = explained(outcome);
    for (const auto& other : outcomes) {
      if (other != outcome) own.remove(explained(other));
    }
    const auto m = static_cast<double>(own.count());
    if (m == 0) return true;
    const double loss = m * (-std::log(p_min_) - 1 - std::log(static_cast<double>(cases_.size()) / m));
    return alpha_ * static_cast<double>(outcome.size()) > loss;
  }

  std::vector<std::vector<Outcome>> neighbours(const std::vector<Outcome>& outcomes) {
    std::vector<std::vector<Outcome>> found;
    const auto without = [](std::vector<Outcome> from, const Outcome& outcome) {
      std::erase(from, outcome);
      return from;
    };
    for (const auto& outcome : outcomes) {
      if (may_go(outcomes, outcome)) found.push_back(without(outcomes, outcome));
    }
    for (std::size_t a = 0; a < outcomes.size(); ++a) {
      for (std::size_t b = a + 1; b < outcomes.size(); ++b) {
        const auto both = conjunction(outcomes[a], outcomes[b]);
        if (!both || std::binary_search(outcomes.begin(), outcomes.end(), *both)) continue;
        // A merge is of use only where it explains examples of both.
        if (!explained(*both).intersects(explained(outcomes[a])) ||
            !explained(*both).intersects(explained(outcomes[b]))) {
          continue;
        }
        auto added = outcomes;
        added.insert(std::lower_bound(added.begin(), added.end(), *both), *both);
        found.push_back(without(without(added, outcomes[a]), outcomes[b]));
        found.push_back(without(added, outcomes[a]));
        found.push_back(without(added, outcomes[b]));
        found.push_back(std::move(added));
      }
    }
    return found;
  }

  const std::vector<EffectCase>& cases_;
  double alpha_, p_min_;
  std::map<Outcome, std::vector<std::size_t>> groups_;  // cases by their change
  std::map<Outcome, Bits> explained_;
};

}  // namespace

InducedOutcomes induce_outcomes(const std::vector<EffectCase>& cases, double alpha, double p_min) {
  return Inducer(cases, alpha, p_min).run();
}

}  // namespace primo::rules
