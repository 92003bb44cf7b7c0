// Sobol: the points of a randomly shifted Sobol sequence; the best one is the result. Monte Carlo without its clusters
// and holes.
#include "core/random.h"
#include "optim/sampling.h"
#include "optim/sobol_sequence.h"

namespace primo::optim {
namespace {

class Sobol final : public Sampling {
 public:
  Sobol(const OptimizerSettings& settings, const Bounds& bounds) : Sampling(settings, bounds), sequence_(dimension()) {
    Random random(settings.seed, "sobol", {static_cast<std::uint64_t>(settings.restart)});
    for (int i = 0; i < dimension(); ++i) shift_.push_back(random.bits());
    begin();
  }

 private:
  std::vector<double> sample(int number) const override {
    const auto point = sequence_.point(static_cast<std::uint32_t>(number));
    std::vector<double> u(point.size());
    // A digital shift keeps the sequence's nets; the bits below the sequence's own are random.
    for (std::size_t i = 0; i < u.size(); ++i) {
      const std::uint64_t word = (std::uint64_t{point[i]} << 32) ^ shift_[i];
      u[i] = static_cast<double>(word >> 11) * 0x1.0p-53;
    }
    return in_box(u);
  }

  SobolSequence sequence_;
  std::vector<std::uint64_t> shift_;
};

}  // namespace

std::unique_ptr<Optimizer> make_sobol(const OptimizerSettings& settings, const Bounds& bounds) {
  return std::make_unique<Sobol>(settings, bounds);
}

}  // namespace primo::optim
