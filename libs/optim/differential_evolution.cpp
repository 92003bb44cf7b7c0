// Differential evolution, DE/rand/1/bin (Storn and Price, J. Global Optimization 11 (1997)) with the scale factor drawn
// anew for each generation: the first generation is uniform in the box; afterwards member k competes with its trial
// v = a + F (b − c), crossed with itself. A coordinate of v outside the box is set between the boundary and a's.
#include <algorithm>
#include <cmath>

#include "core/random.h"
#include "optim/algorithms.h"
#include "optim/generational.h"

namespace primo::optim {
namespace {

constexpr double kCrossover = 0.9;
constexpr double kLeastScale = 0.5, kGreatestScale = 1.0;

class DifferentialEvolution final : public Generational {
 public:
  DifferentialEvolution(const OptimizerSettings& settings, const Bounds& bounds)
      : Generational(settings, bounds),
        population_(settings.population > 0 ? settings.population : default_evolution_population(bounds.lower.size())) {
    begin();
  }

 private:
  using Point = std::vector<double>;  // of the unit box

  Random stream(const char* purpose, int index) const {
    return Random(settings().seed, purpose,
                  {static_cast<std::uint64_t>(settings().restart), static_cast<std::uint64_t>(number()),
                   static_cast<std::uint64_t>(index)});
  }

  /// Three different members, none of them k.
  std::array<std::size_t, 3> partners(int k, Random& random) const {
    std::array<std::size_t, 4> taken{static_cast<std::size_t>(k)};
    for (std::size_t i = 1; i < 4; ++i) {
      do {
        taken[i] = random.below(members_.size());
      } while (std::find(taken.begin(), taken.begin() + static_cast<std::ptrdiff_t>(i), taken[i]) !=
               taken.begin() + static_cast<std::ptrdiff_t>(i));
    }
    return {taken[1], taken[2], taken[3]};
  }

  Point trial(int k) const {
    Random random = stream("differential_evolution", k);
    Point u(static_cast<std::size_t>(dimension()));
    if (members_.empty()) {
      for (auto& coordinate : u) coordinate = random.uniform();
      return u;
    }
    const double F = stream("differential_evolution scale", 0).uniform(kLeastScale, kGreatestScale);
    const auto [a, b, c] = partners(k, random);
    const auto& own = members_[static_cast<std::size_t>(k)];
    const std::size_t kept = random.below(u.size());  // this one is the mutant's in any case
    for (std::size_t i = 0; i < u.size(); ++i) {
      const double share = random.uniform(), fallback = random.uniform();
      double v = members_[a][i] + F * (members_[b][i] - members_[c][i]);
      if (v < 0) v = fallback * members_[a][i];
      if (v > 1) v = 1 - fallback * (1 - members_[a][i]);
      u[i] = share < kCrossover || i == kept ? v : own[i];
    }
    return u;
  }

  std::vector<Point> samples() const override {
    std::vector<Point> points;
    points.reserve(static_cast<std::size_t>(size()));
    for (int k = 0; k < size(); ++k) points.push_back(in_box(trial(k)));
    return points;
  }

  void advance(const std::vector<double>& fitness) override {
    std::vector<Point> next = members_;
    next.resize(fitness.size());
    fitness_.resize(fitness.size());
    for (std::size_t k = 0; k < fitness.size(); ++k) {
      // Of equals the trial, so that a plateau is crossed.
      if (!members_.empty() && fitness[k] < fitness_[k]) continue;
      next[k] = trial(static_cast<int>(k));
      fitness_[k] = fitness[k];
    }
    members_ = std::move(next);
  }

  int wanted() const override { return population_; }

  void save(State& state) const override {
    auto& points = state["members"];
    for (const auto& member : members_) points.insert(points.end(), member.begin(), member.end());
    state["fitness"] = fitness_;
  }
  Status load(const StateReader& state) override {
    PRIMO_ASSIGN(fitness_, state.numbers("fitness"));
    if (!fitness_.empty() && fitness_.size() != static_cast<std::size_t>(population_)) {
      return Error{Code::data, "the optimizer's state: 'fitness' is not of the whole population"};
    }
    const auto d = static_cast<std::size_t>(dimension());
    PRIMO_ASSIGN(const auto points, state.numbers("members", fitness_.size() * d));
    if (std::any_of(points.begin(), points.end(), [](double u) { return u < 0 || u > 1; })) {
      return Error{Code::data, "the optimizer's state: 'members' leave the box"};
    }
    members_.clear();
    for (std::size_t k = 0; k < fitness_.size(); ++k) {
      const auto first = points.begin() + static_cast<std::ptrdiff_t>(k * d);
      members_.emplace_back(first, first + static_cast<std::ptrdiff_t>(d));
    }
    return success();
  }

  int population_;
  std::vector<Point> members_;
  std::vector<double> fitness_;  // of the members
};

}  // namespace

int default_evolution_population(std::size_t dimension) {
  return static_cast<int>(std::clamp<std::size_t>(5 * dimension, 10, 200));
}

std::unique_ptr<Optimizer> make_differential_evolution(const OptimizerSettings& settings, const Bounds& bounds) {
  return std::make_unique<DifferentialEvolution>(settings, bounds);
}

}  // namespace primo::optim
