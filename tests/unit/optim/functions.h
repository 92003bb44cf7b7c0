// What the tests of optimizers share.
#pragma once

#include <gtest/gtest.h>

#include <functional>
#include <memory>
#include <vector>

#include "optim/optimizer.h"
#include "optim/test_functions.h"

namespace primo::optim::test {

using Cost = std::function<double(const std::vector<double>&)>;

inline Bounds box(int d, double lower, double upper) {
  return {std::vector<double>(static_cast<std::size_t>(d), lower),
          std::vector<double>(static_cast<std::size_t>(d), upper)};
}

inline Cost function(const char* name) {
  const auto* found = find_test_function(name).value();
  return [found](const std::vector<double>& x) { return found->cost(x); };
}

inline std::unique_ptr<Optimizer> make(const OptimizerSettings& settings, const Bounds& bounds) {
  auto made = make_optimizer(settings, bounds);
  EXPECT_TRUE(made.ok()) << (made.ok() ? "" : made.error().message);
  return std::move(made).value();
}

/// Tells the present generation its costs.
inline void generation(Optimizer& optimizer, const Cost& cost) {
  for (const auto& c : optimizer.ask()) ASSERT_TRUE(optimizer.tell(c.generation, c.index, -cost(c.x)).ok());
}

inline void run(Optimizer& optimizer, const Cost& cost) {
  while (!optimizer.done()) generation(optimizer, cost);
}

/// Evaluations until `cost` falls to `target`; the budget when it does not.
inline int evaluations_to(const Cost& cost, double target, const OptimizerSettings& settings, const Bounds& bounds) {
  const auto optimizer = make(settings, bounds);
  while (!optimizer->done()) {
    for (const auto& candidate : optimizer->ask()) {
      const double value = cost(candidate.x);
      EXPECT_TRUE(optimizer->tell(candidate.generation, candidate.index, -value).ok());
      if (value <= target) return optimizer->evaluations();
    }
  }
  return settings.evaluations;
}

}  // namespace primo::optim::test
