// Monte Carlo: candidates uniform in the box; the best one is the result. The paper's baseline.
#include <algorithm>

#include "core/random.h"
#include "optim/algorithms.h"
#include "optim/generation.h"

namespace primo::optim {
namespace {

class MonteCarlo final : public Optimizer {
 public:
  MonteCarlo(const OptimizerSettings& settings, const Bounds& bounds)
      : settings_(settings),
        bounds_(bounds),
        population_(settings.population > 0 ? settings.population : default_population(bounds.lower.size())),
        generation_(std::min(population_, settings.evaluations)) {}

  std::vector<Candidate> ask() const override {
    std::vector<Candidate> candidates;
    if (done()) return candidates;
    for (int k = 0; k < generation_.size(); ++k) candidates.push_back({generation_.number(), k, sample(k)});
    return candidates;
  }

  Status tell(int generation, int index, double fitness) override {
    PRIMO_ASSIGN(const bool fresh, generation_.tell(generation, index, fitness));
    if (!fresh || done()) return success();
    ++evaluations_;
    if (!generation_.complete()) return success();
    for (int k = 0; k < generation_.size(); ++k) best_.consider(sample(k), generation_.fitness(k));
    if (!done()) generation_.next(std::min(population_, settings_.evaluations - evaluations_));
    return success();
  }

  bool done() const override { return evaluations_ >= settings_.evaluations; }
  std::string stop_reason() const override {
    return done() ? "the budget of " + std::to_string(settings_.evaluations) + " evaluations is spent" : "";
  }
  int evaluations() const override { return evaluations_; }
  std::vector<double> recommendation() const override { return best(); }
  std::vector<double> best() const override { return best_.x.empty() ? sample(0) : best_.x; }
  double best_fitness() const override { return best_.fitness; }

 private:
  std::vector<double> sample(int index) const {
    Random random(settings_.seed, "monte_carlo",
                  {static_cast<std::uint64_t>(settings_.restart), static_cast<std::uint64_t>(generation_.number()),
                   static_cast<std::uint64_t>(index)});
    std::vector<double> x(bounds_.lower.size());
    for (std::size_t i = 0; i < x.size(); ++i) x[i] = random.uniform(bounds_.lower[i], bounds_.upper[i]);
    return x;
  }

  OptimizerSettings settings_;
  Bounds bounds_;
  int population_;
  Generation generation_;
  int evaluations_ = 0;
  Best best_;
};

}  // namespace

std::unique_ptr<Optimizer> make_monte_carlo(const OptimizerSettings& settings, const Bounds& bounds) {
  return std::make_unique<MonteCarlo>(settings, bounds);
}

}  // namespace primo::optim
