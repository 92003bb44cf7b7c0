// Sobol: the points of a randomly shifted Sobol sequence; the best one is the result. Monte Carlo without its clusters
// and holes.
#include <algorithm>

#include "core/random.h"
#include "optim/algorithms.h"
#include "optim/generational.h"
#include "optim/sobol_sequence.h"

namespace primo::optim {
namespace {

class Sobol final : public Generational {
 public:
  Sobol(const OptimizerSettings& settings, const Bounds& bounds)
      : Generational(settings, bounds),
        population_(settings.population > 0 ? settings.population : default_population(bounds.lower.size())),
        sequence_(dimension()) {
    Random random(settings.seed, "sobol", {static_cast<std::uint64_t>(settings.restart)});
    for (int i = 0; i < dimension(); ++i) shift_.push_back(random.bits());
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
    const auto point = sequence_.point(static_cast<std::uint32_t>(before() + index));
    std::vector<double> u(point.size());
    // A digital shift keeps the sequence's nets; the bits below the sequence's own are random.
    for (std::size_t i = 0; i < u.size(); ++i) {
      const std::uint64_t word = (std::uint64_t{point[i]} << 32) ^ shift_[i];
      u[i] = static_cast<double>(word >> 11) * 0x1.0p-53;
    }
    return in_box(u);
  }
  void advance(const std::vector<double>&) override {}
  int wanted() const override { return std::clamp(settings().evaluations - evaluations(), 0, population_); }
  void save(State&) const override {}
  Status load(const StateReader&) override { return success(); }

  int population_;
  SobolSequence sequence_;
  std::vector<std::uint64_t> shift_;
};

}  // namespace

std::unique_ptr<Optimizer> make_sobol(const OptimizerSettings& settings, const Bounds& bounds) {
  return std::make_unique<Sobol>(settings, bounds);
}

}  // namespace primo::optim
