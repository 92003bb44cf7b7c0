#include "core/statistics.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>

#include "core/random.h"

namespace primo {
namespace {

/// n pairs of which `both`, `first` alone and `second` alone have these probabilities.
Paired draw(Random& random, int n, double both, double first, double second) {
  Paired pair;
  for (int i = 0; i < n; ++i) {
    const double u = random.uniform();
    pair.add(u < both + first, u < both || (u >= both + first && u < both + first + second));
  }
  return pair;
}

TEST(Paired, counts_each_pair_once_and_its_rates_are_those_of_the_two) {
  Paired pair;
  for (int i = 0; i < 10; ++i) pair.add(i < 3, i >= 2 && i < 9);
  EXPECT_EQ(pair, (Paired{1, 2, 6, 1}));
  EXPECT_EQ(pair.first().successes, 3);
  EXPECT_EQ(pair.second().successes, 7);
  EXPECT_NEAR(pair.difference(), 0.4, 1e-15);
}

TEST(Paired, p_value_is_that_of_a_fair_coin) {
  EXPECT_DOUBLE_EQ((Paired{5, 0, 0, 5}).p_value(), 1.0);
  EXPECT_NEAR((Paired{0, 2, 10, 0}).p_value(), 2.0 * (1 + 12 + 66) / 4096, 1e-12);
  EXPECT_NEAR((Paired{7, 10, 2, 3}).p_value(), 2.0 * (1 + 12 + 66) / 4096, 1e-12) << "either way round";
  EXPECT_DOUBLE_EQ((Paired{0, 6, 6, 0}).p_value(), 1.0);
  EXPECT_NEAR((Paired{0, 0, 1000, 200}).p_value(), std::ldexp(1.0, -999), 1e-302) << "far tails do not vanish";
}

TEST(Paired, interval_of_independent_successes_adds_the_squares_of_wilsons) {
  const Paired pair{10, 20, 30, 60};  // 10 · 60 = 20 · 30: no correlation
  const auto first = pair.first(), second = pair.second();
  EXPECT_NEAR(pair.lower(),
              pair.difference() - std::hypot(second.value() - second.lower(), first.upper() - first.value()), 1e-12);
  EXPECT_NEAR(pair.upper(),
              pair.difference() + std::hypot(second.upper() - second.value(), first.value() - first.lower()), 1e-12);
  EXPECT_EQ((Paired{}).lower(), -1);
  EXPECT_EQ((Paired{}).upper(), 1);
}

TEST(Paired, interval_covers_the_truth_as_often_as_it_says) {
  Random random(11, "statistics test");
  for (const auto& [both, first, second] : {std::array{0.3, 0.05, 0.35}, std::array{0.85, 0.02, 0.1}}) {
    int covered = 0;
    constexpr int kRuns = 2000;
    for (int run = 0; run < kRuns; ++run) {
      const auto pair = draw(random, 120, both, first, second);
      covered += pair.lower() <= second - first && second - first <= pair.upper();
    }
    EXPECT_GE(covered, 0.93 * kRuns);
    EXPECT_LE(covered, 0.985 * kRuns);
  }
}

TEST(Paired, detectable_difference_is_found_with_the_power_it_says) {
  // 300 pairs, a fifth of them discordant: a true difference of this size, found by McNemar's test at 5 %.
  const Paired seen{150, 30, 30, 90};
  const double d = seen.detectable(0.8);
  ASSERT_GT(d, 0.0);
  ASSERT_LT(d, 0.2);
  Random random(12, "statistics test");
  int found = 0;
  constexpr int kRuns = 4000;
  for (int run = 0; run < kRuns; ++run) {
    const auto pair = draw(random, 300, 0.5, (0.2 - d) / 2, (0.2 + d) / 2);
    const auto b = static_cast<double>(pair.first_only), c = static_cast<double>(pair.second_only);
    found += std::abs(b - c) > Rate::kZ95 * std::sqrt(b + c);
  }
  EXPECT_NEAR(static_cast<double>(found) / kRuns, 0.8, 0.025);
  EXPECT_GT(seen.detectable(0.95), d);
  EXPECT_EQ((Paired{}).detectable(), 1);
  EXPECT_LT((Paired{300, 0, 0, 0}).detectable(), 0.05);
}

}  // namespace
}  // namespace primo
