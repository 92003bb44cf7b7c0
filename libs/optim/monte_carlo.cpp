// Monte Carlo: candidates uniform in the box; the best one is the result. The paper's baseline. The n-th evaluation is
// the same point whatever the size of a generation.
#include <algorithm>

#include "core/random.h"
#include "optim/algorithms.h"
#include "optim/generational.h"

namespace primo::optim {
namespace {

class MonteCarlo final : public Generational {
 public:
  MonteCarlo(const OptimizerSettings& settings, const Bounds& bounds)
      : Generational(settings, bounds),
        population_(settings.population > 0 ? settings.population : default_population(bounds.lower.size())) {
    begin();
  }

 private:
  std::vector<std::vector<double>> samples() const override {
    std::vector<std::vector<double>> points;
    points.reserve(static_cast<std::size_t>(size()));
    for (int k = 0; k < size(); ++k) points.push_back(sample(k));
    return points;
  }
  std::vector<double> sample(int index) const {
    Random random(settings().seed, "monte_carlo",
                  {static_cast<std::uint64_t>(settings().restart), static_cast<std::uint64_t>(before() + index)});
    std::vector<double> x(bounds().lower.size());
    for (std::size_t i = 0; i < x.size(); ++i) x[i] = random.uniform(bounds().lower[i], bounds().upper[i]);
    return x;
  }
  void advance(const std::vector<double>&) override {}
  int wanted() const override { return std::clamp(settings().evaluations - evaluations(), 0, population_); }
  void save(State&) const override {}
  Status load(const StateReader&) override { return success(); }

  int population_;
};

}  // namespace

std::unique_ptr<Optimizer> make_monte_carlo(const OptimizerSettings& settings, const Bounds& bounds) {
  return std::make_unique<MonteCarlo>(settings, bounds);
}

}  // namespace primo::optim
