#include "optim/optimizer.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "core/random.h"
#include "functions.h"

namespace primo::optim {
namespace {

using test::box;
using test::make;

class EachOptimizer : public testing::TestWithParam<std::string> {};
INSTANTIATE_TEST_SUITE_P(Table, EachOptimizer, testing::ValuesIn(optimizer_names()));

TEST_P(EachOptimizer, gives_the_same_bits_for_results_in_any_order_doubled_or_late) {
  const OptimizerSettings settings{.name = GetParam(), .evaluations = 600, .seed = 11};
  const auto bounds = box(7, -3, 5);
  const auto straight = make(settings, bounds), shuffled = make(settings, bounds);
  Random random(1, "order");
  while (!straight->done()) {
    const auto candidates = straight->ask();
    auto others = shuffled->ask();
    ASSERT_EQ(candidates.size(), others.size());
    for (std::size_t k = 0; k < candidates.size(); ++k) ASSERT_EQ(candidates[k].x, others[k].x);
    for (const auto& c : candidates)
      ASSERT_TRUE(straight->tell(c.generation, c.index, -test::function("rosenbrock")(c.x)).ok());
    for (std::size_t k = others.size(); k > 1; --k) std::swap(others[k - 1], others[random.below(k)]);
    for (std::size_t k = 0; k < others.size(); ++k) {
      const auto& c = others[k];
      ASSERT_TRUE(shuffled->tell(c.generation, c.index, -test::function("rosenbrock")(c.x)).ok());
      ASSERT_TRUE(shuffled->tell(c.generation, c.index, 1e6).ok()) << "a doubled result is ignored";
      if (c.generation > 0) {
        ASSERT_TRUE(shuffled->tell(c.generation - 1, 0, 1e6).ok()) << "a late result is ignored";
      }
      if (k + 1 < others.size()) {
        ASSERT_EQ(shuffled->ask()[0].x, candidates[0].x) << "ask does not change the state";
      }
    }
  }
  EXPECT_TRUE(shuffled->done());
  EXPECT_EQ(straight->evaluations(), shuffled->evaluations());
  EXPECT_EQ(straight->recommendation(), shuffled->recommendation());
  EXPECT_EQ(straight->best(), shuffled->best());
  EXPECT_EQ(straight->best_fitness(), shuffled->best_fitness());
}

TEST_P(EachOptimizer, spends_the_budget_on_a_flat_fitness_and_stays_in_the_box) {
  const auto optimizer = make({.name = GetParam(), .evaluations = 2000}, box(12, -3, 9));
  const int generation = static_cast<int>(optimizer->ask().size());
  while (!optimizer->done()) {
    EXPECT_EQ(optimizer->stop_reason(), "");
    for (const auto& candidate : optimizer->ask()) {
      for (const double value : candidate.x) ASSERT_TRUE(value >= -3 && value <= 9);
      ASSERT_TRUE(optimizer->tell(candidate.generation, candidate.index, 0.5).ok());
    }
  }
  EXPECT_LE(optimizer->evaluations(), 2000);
  EXPECT_GT(optimizer->evaluations(), 2000 - 4 * generation);
  EXPECT_NE(optimizer->stop_reason(), "");
  EXPECT_TRUE(optimizer->ask().empty());
}

TEST_P(EachOptimizer, depends_on_seed_and_restart) {
  const auto bounds = box(5, 0, 1);
  const auto first = make({.name = GetParam()}, bounds)->ask()[0].x;
  EXPECT_EQ(first, make({.name = GetParam()}, bounds)->ask()[0].x);
  EXPECT_NE(first, make({.name = GetParam(), .seed = 2}, bounds)->ask()[0].x);
  EXPECT_NE(first, make({.name = GetParam(), .restart = 1}, bounds)->ask()[0].x);
}

TEST_P(EachOptimizer, stays_finite_for_extreme_fitness_values) {
  const auto optimizer = make({.name = GetParam(), .evaluations = 3000}, box(3, -1, 1));
  Random random(5, "extreme");
  while (!optimizer->done()) {
    for (const auto& candidate : optimizer->ask()) {
      for (const double value : candidate.x) ASSERT_TRUE(std::isfinite(value));
      const double values[] = {-1.7e308, 1.7e308, 0, 1e-308, candidate.x[0]};
      ASSERT_TRUE(optimizer->tell(candidate.generation, candidate.index, values[random.below(5)]).ok());
    }
  }
  for (const double value : optimizer->recommendation()) EXPECT_TRUE(value >= -1 && value <= 1);
}

TEST_P(EachOptimizer, refuses_what_is_not_a_fitness_or_not_a_candidate) {
  const auto optimizer = make({.name = GetParam()}, box(2, 0, 1));
  EXPECT_FALSE(optimizer->tell(0, 0, NAN).ok());
  EXPECT_FALSE(optimizer->tell(0, 0, INFINITY).ok());
  EXPECT_FALSE(optimizer->tell(0, -1, 0).ok());
  EXPECT_FALSE(optimizer->tell(0, 1000, 0).ok());
  EXPECT_FALSE(optimizer->tell(1, 0, 0).ok()) << "not asked yet";
  EXPECT_EQ(optimizer->evaluations(), 0);
}

TEST_P(EachOptimizer, works_in_one_dimension_and_with_the_smallest_population) {
  const bool evolution = GetParam() == "differential_evolution";
  for (const int population : evolution ? std::vector{0, 4, 5} : std::vector{0, 2, 3}) {
    const auto optimizer = make({.name = GetParam(), .evaluations = 400, .population = population}, box(1, -2, 3));
    while (!optimizer->done()) {
      for (const auto& c : optimizer->ask())
        ASSERT_TRUE(optimizer->tell(c.generation, c.index, -std::abs(c.x[0] - 1)).ok());
    }
    EXPECT_NEAR(optimizer->recommendation()[0], 1, 0.1) << "population " << population;
  }
}

TEST_P(EachOptimizer, goes_on_from_its_state_at_any_moment_with_the_same_bits) {
  const OptimizerSettings settings{.name = GetParam(), .evaluations = 500, .seed = 3};
  const auto bounds = box(5, -2, 6);
  const auto cost = test::function("rosenbrock");
  const auto straight = make(settings, bounds);
  auto broken = make(settings, bounds);
  int told = 0;
  while (!straight->done()) {
    test::generation(*straight, cost);
    for (const auto& c : broken->ask()) {
      ASSERT_TRUE(broken->tell(c.generation, c.index, -cost(c.x)).ok());
      if (++told % 7 != 0) continue;  // in the middle of a generation, at its end, wherever it comes
      auto other = make(settings, bounds);
      const auto restored = other->restore(broken->state());
      ASSERT_TRUE(restored.ok()) << restored.error().message;
      ASSERT_EQ(other->state(), broken->state());
      broken = std::move(other);
    }
  }
  EXPECT_TRUE(broken->done());
  EXPECT_EQ(straight->state(), broken->state());
  EXPECT_EQ(straight->recommendation(), broken->recommendation());
  EXPECT_EQ(straight->stop_reason(), broken->stop_reason());
}

TEST_P(EachOptimizer, with_a_greater_budget_goes_on_as_if_it_had_had_it_from_the_beginning) {
  const auto bounds = box(3, -2, 6);
  const auto cost = test::function("rosenbrock");
  const auto once = make({.name = GetParam(), .evaluations = 1000}, bounds);
  test::run(*once, cost);
  const auto first = make({.name = GetParam(), .evaluations = 333}, bounds);
  test::run(*first, cost);
  const auto second = make({.name = GetParam(), .evaluations = 1000}, bounds);
  ASSERT_TRUE(second->restore(first->state()).ok());
  test::run(*second, cost);
  EXPECT_EQ(once->evaluations(), second->evaluations());
  EXPECT_EQ(once->best(), second->best());
  EXPECT_EQ(once->recommendation(), second->recommendation());
}

TEST_P(EachOptimizer, refuses_states_that_cannot_be_and_survives_any) {
  const auto bounds = box(3, -2, 6);
  const OptimizerSettings settings{.name = GetParam(), .evaluations = 300};
  const auto source = make(settings, bounds);
  for (int g = 0; g < 4; ++g) test::generation(*source, test::function("sphere"));
  const State good = source->state();
  for (const auto& [name, values] : good) {
    State state = good;
    state.erase(name);
    const auto missing = make(settings, bounds)->restore(state);
    ASSERT_FALSE(missing.ok()) << name;
    EXPECT_NE(missing.error().message.find("'" + name + "' is missing"), std::string::npos) << missing.error().message;
    state = good;
    state[name].push_back(NAN);
    EXPECT_FALSE(make(settings, bounds)->restore(state).ok()) << name;
  }
  Random random(4, "states");
  const double odd[] = {-1, 0, 0.5, 1, 3, 1e9, 1e300, -1e300, 5e-324};
  for (int i = 0; i < 3000; ++i) {
    State state = good;
    for (int changes = 0; changes < 2; ++changes) {
      auto at = state.begin();
      std::advance(at, random.below(state.size()));
      if (!at->second.empty()) at->second[random.below(at->second.size())] = odd[random.below(9)];
    }
    const auto optimizer = make(settings, bounds);
    if (!optimizer->restore(state).ok()) continue;
    // What is taken may be a strange state, but the optimizer lives in it and stays in the box.
    for (int g = 0; g < 3 && !optimizer->done(); ++g) {
      const auto candidates = optimizer->ask();
      ASSERT_LE(candidates.size(), 300u);
      for (const auto& c : candidates) {
        for (const double x : c.x) ASSERT_TRUE(x >= -2 && x <= 6) << x;
        ASSERT_TRUE(optimizer->tell(c.generation, c.index, -c.x[0]).ok());
      }
    }
  }
}

TEST(MonteCarlo, recommends_its_best_sample_and_spends_the_exact_budget) {
  const auto optimizer = make({.name = "monte_carlo", .evaluations = 103, .population = 10}, box(2, -1, 1));
  double best = -INFINITY;
  while (!optimizer->done()) {
    for (const auto& c : optimizer->ask()) {
      best = std::max(best, -test::function("sphere")(c.x));
      ASSERT_TRUE(optimizer->tell(c.generation, c.index, -test::function("sphere")(c.x)).ok());
    }
  }
  EXPECT_EQ(optimizer->evaluations(), 103);
  EXPECT_EQ(optimizer->best_fitness(), best);
  EXPECT_EQ(-test::function("sphere")(optimizer->recommendation()), best);
}

TEST(MakeOptimizer, says_what_is_wrong_and_what_would_be_right) {
  const auto message = [](const OptimizerSettings& settings, const Bounds& bounds) {
    const auto made = make_optimizer(settings, bounds);
    EXPECT_FALSE(made.ok());
    EXPECT_EQ(made.error().code, Code::config);
    return made.error().message;
  };
  EXPECT_NE(message({.name = "cam"}, box(2, 0, 1)).find("known: cma, monte_carlo, sobol, differential_evolution"),
            std::string::npos);
  EXPECT_NE(message({}, box(2, 1, 0)).find("lower below the upper"), std::string::npos);
  EXPECT_NE(message({}, {{0, 0}, {1}}).find("2 and 1"), std::string::npos);
  EXPECT_NE(message({}, {}).find("at least 1"), std::string::npos);
  EXPECT_NE(message({.evaluations = 5}, box(10, 0, 1)).find("below one generation of 10"), std::string::npos);
  EXPECT_NE(message({.population = 1}, box(2, 0, 1)).find("population is 1"), std::string::npos);
  EXPECT_NE(message({.name = "differential_evolution", .population = 3}, box(2, 0, 1)).find("at least 4"),
            std::string::npos);
  EXPECT_NE(message({.name = "differential_evolution", .evaluations = 49}, box(10, 0, 1)).find("generation of 50"),
            std::string::npos);
  EXPECT_NE(message({.on_stagnation = "panic"}, box(2, 0, 1)).find("ipop, bipop, again or stop"), std::string::npos);
  EXPECT_NE(message({.sigma = NAN}, box(2, 0, 1)).find("sigma"), std::string::npos);
  EXPECT_NE(message({}, {{0, NAN}, {1, 1}}).find("coordinate 1"), std::string::npos);
}

}  // namespace
}  // namespace primo::optim
