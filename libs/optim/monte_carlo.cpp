// Monte Carlo: candidates uniform in the box; the best one is the result. The paper's baseline. The n-th evaluation is
// the same point whatever the size of a generation.
#include "core/random.h"
#include "optim/sampling.h"

namespace primo::optim {
namespace {

class MonteCarlo final : public Sampling {
 public:
  MonteCarlo(const OptimizerSettings& settings, const Bounds& bounds) : Sampling(settings, bounds) { begin(); }

 private:
  std::vector<double> sample(int number) const override {
    Random random(settings().seed, "monte_carlo",
                  {static_cast<std::uint64_t>(settings().restart), static_cast<std::uint64_t>(number)});
    std::vector<double> x(bounds().lower.size());
    for (std::size_t i = 0; i < x.size(); ++i) x[i] = random.uniform(bounds().lower[i], bounds().upper[i]);
    return x;
  }
};

}  // namespace

std::unique_ptr<Optimizer> make_monte_carlo(const OptimizerSettings& settings, const Bounds& bounds) {
  return std::make_unique<MonteCarlo>(settings, bounds);
}

}  // namespace primo::optim
