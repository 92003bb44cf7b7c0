#include "rules/outcomes.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>

#include "rules/bits.h"

namespace primo::rules {
namespace {

constexpr double kImprovement = 1e-9;

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
  Inducer(const std::vector<Scene>& scenes, const Covered& covered, const std::vector<int>& numbers,
          const std::vector<const Outcome*>& changes, double alpha, double p_min)
      : scenes_(scenes), covered_(covered), alpha_(alpha), p_min_(p_min) {
    for (std::size_t i = 0; i < covered.size(); ++i) {
      if (numbers[i] >= 0) {
        groups_[*changes[static_cast<std::size_t>(numbers[i])]].push_back(i);
      } else {
        ++inexpressible_;
      }
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
  /// The examples that an outcome takes from s to s′: every change is in it, and all of it holds afterwards.
  const Bits& explained(const Outcome& outcome) {
    const auto [at, fresh] = explained_.try_emplace(outcome, covered_.size());
    if (!fresh) return at->second;
    for (const auto& [change, members] : groups_) {
      if (!std::includes(outcome.begin(), outcome.end(), change.begin(), change.end())) continue;
      Outcome rest;
      std::set_difference(outcome.begin(), outcome.end(), change.begin(), change.end(), std::back_inserter(rest));
      for (const auto i : members) {
        const bool holds = std::all_of(rest.begin(), rest.end(), [&](const LiftedLiteral& literal) {
          return holds_after(scenes_[covered_.examples[i]], literal, covered_.binding(i));
        });
        if (holds) at->second.set(i);
      }
    }
    return at->second;
  }

  std::vector<MixtureCell> cells(const std::vector<Outcome>& outcomes) {
    std::map<std::vector<int>, double> weights;
    if (inexpressible_ > 0) weights[{}] += static_cast<double>(inexpressible_);
    std::vector<int> explanation;
    for (const auto& [change, members] : groups_) {
      std::vector<std::pair<int, const Bits*>> possible;
      for (std::size_t o = 0; o < outcomes.size(); ++o) {
        if (std::includes(outcomes[o].begin(), outcomes[o].end(), change.begin(), change.end())) {
          possible.emplace_back(static_cast<int>(o), &explained(outcomes[o]));
        }
      }
      // Only the change itself, and so all of the group's examples.
      if (possible.size() == 1 && outcomes[static_cast<std::size_t>(possible[0].first)].size() == change.size()) {
        weights[{possible[0].first}] += static_cast<double>(members.size());
        continue;
      }
      for (const auto i : members) {
        explanation.clear();
        for (const auto& [o, bits] : possible) {
          if (bits->test(i)) explanation.push_back(o);
        }
        ++weights[explanation];
      }
    }
    std::vector<MixtureCell> cells;
    for (const auto& [outcomes_of_cell, weight] : weights) cells.push_back({outcomes_of_cell, weight});
    return cells;
  }

  InducedOutcomes evaluate(const std::vector<Outcome>& outcomes) {
    InducedOutcomes induced;
    auto fit = fit_outcomes(cells(outcomes), static_cast<int>(outcomes.size()), p_min_);
    Bits any(covered_.size());
    std::size_t literals = 0;
    for (std::size_t o = 0; o < outcomes.size(); ++o) {
      if (!(fit.p[o] > 0)) continue;
      induced.outcomes.push_back(outcomes[o]);
      induced.fit.p.push_back(fit.p[o]);
      induced.counts.push_back(explained(outcomes[o]).count());
      any |= explained(outcomes[o]);
      literals += outcomes[o].size();
    }
    induced.noise_count = static_cast<std::int64_t>(covered_.size()) - any.count();
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
    const double loss = m * (-std::log(p_min_) - 1 - std::log(static_cast<double>(covered_.size()) / m));
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

  const std::vector<Scene>& scenes_;
  const Covered& covered_;
  double alpha_, p_min_;
  std::size_t inexpressible_ = 0;
  std::map<Outcome, std::vector<std::size_t>> groups_;  // covered examples by their change
  std::map<Outcome, Bits> explained_;
};

}  // namespace

InducedOutcomes induce_outcomes(const std::vector<Scene>& scenes, const Covered& covered,
                                const std::vector<int>& numbers, const std::vector<const Outcome*>& changes,
                                double alpha, double p_min) {
  return Inducer(scenes, covered, numbers, changes, alpha, p_min).run();
}

}  // namespace primo::rules
