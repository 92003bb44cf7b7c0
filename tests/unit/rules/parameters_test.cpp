#include "rules/parameters.h"

#include <gtest/gtest.h>

#include <cmath>

#include "core/random.h"

namespace primo::rules {
namespace {

constexpr double kPMin = 1e-8;

double log_likelihood(const std::vector<MixtureCell>& cells, const std::vector<double>& p, double noise, double p_min) {
  double sum = 0;
  for (const auto& cell : cells) {
    double likelihood = p_min * noise;
    for (const int i : cell.outcomes) likelihood += p[static_cast<std::size_t>(i)];
    sum += cell.weight * std::log(likelihood);
  }
  return sum;
}

TEST(FitOutcomes, without_overlap_gives_the_shares) {
  const auto fit = fit_outcomes({{{0}, 47}, {{1}, 2}, {{}, 1}}, 2, kPMin);
  EXPECT_NEAR(fit.p[0], 0.94, 1e-8);
  EXPECT_NEAR(fit.p[1], 0.04, 1e-8);
  EXPECT_NEAR(fit.noise, 0.02, 1e-8);
  EXPECT_NEAR(fit.log_likelihood, 47 * std::log(0.94) + 2 * std::log(0.04) + std::log(0.02 * kPMin), 1e-5);
  EXPECT_LT(fit.gap, 1e-7);
}

TEST(FitOutcomes, without_noise_gives_no_noise) {
  const auto fit = fit_outcomes({{{0}, 3}, {{1}, 1}}, 2, kPMin);
  EXPECT_DOUBLE_EQ(fit.p[0], 0.75);
  EXPECT_DOUBLE_EQ(fit.p[1], 0.25);
  EXPECT_EQ(fit.noise, 0);
}

TEST(FitOutcomes, without_examples_is_all_noise) {
  const auto fit = fit_outcomes({}, 2, kPMin);
  EXPECT_EQ(fit.noise, 1);
  EXPECT_EQ(fit.log_likelihood, 0);
}

TEST(FitOutcomes, examples_with_two_explanations_say_nothing_of_their_odds) {
  // p_A + p_B = 1 explains the shared cell for certain, so that only the others count: p_A = 6/(6+2).
  const auto fit = fit_outcomes({{{0}, 6}, {{0, 1}, 100}, {{1}, 2}}, 2, kPMin);
  EXPECT_NEAR(fit.p[0], 0.75, 1e-6);
  EXPECT_NEAR(fit.p[1], 0.25, 1e-6);
  EXPECT_NEAR(fit.log_likelihood, 6 * std::log(0.75) + 2 * std::log(0.25), 1e-6);
}

TEST(FitOutcomes, an_outcome_that_another_covers_wholly_vanishes) {
  const auto fit = fit_outcomes({{{0}, 5}, {{0, 1}, 5}}, 2, kPMin);
  EXPECT_NEAR(fit.p[0], 1, 1e-9);
  EXPECT_EQ(fit.p[1], 0);
}

TEST(FitOutcomes, solves_the_score_equation_of_three_overlapping_cells) {
  // Cells {A}: 3, {B}: 1, {A,C}: 2, {B,C}: 4. With c = p_C = 1 − a − b, the stationary point was found by bisection of
  // the score below.
  const std::vector<MixtureCell> cells{{{0}, 3}, {{1}, 1}, {{0, 2}, 2}, {{1, 2}, 4}};
  const auto fit = fit_outcomes(cells, 3, kPMin);
  double best = -INFINITY;
  for (int i = 1; i < 1000; ++i) {
    for (int j = 1; i + j < 1000; ++j) {
      const double a = i / 1000.0, b = j / 1000.0;
      best = std::max(best, log_likelihood(cells, {a, b, 1 - a - b}, 0, kPMin));
    }
  }
  EXPECT_GE(fit.log_likelihood, best);
  EXPECT_LT(fit.log_likelihood - best, 1e-3) << "the grid is that fine";
}

TEST(FitOutcomes, certifies_the_optimum_of_random_problems) {
  for (std::uint64_t problem = 0; problem < 500; ++problem) {
    Random random(2, "mixture", {problem});
    const int outcomes = 1 + static_cast<int>(random.below(7));
    std::vector<MixtureCell> cells;
    double total = 0;
    for (std::uint64_t c = 1 + random.below(12); c > 0; --c) {
      MixtureCell cell{{}, 1.0 + static_cast<double>(random.below(300))};
      for (int i = 0; i < outcomes; ++i) {
        if (random.below(3) == 0) cell.outcomes.push_back(i);
      }
      total += cell.weight;
      cells.push_back(cell);
    }
    const double p_min = random.below(2) ? 1e-8 : 1e-2;
    const auto fit = fit_outcomes(cells, outcomes, p_min);
    double sum = fit.noise;
    for (const double p : fit.p) {
      EXPECT_GE(p, 0);
      sum += p;
    }
    EXPECT_NEAR(sum, 1, 1e-12);
    EXPECT_NEAR(fit.log_likelihood, log_likelihood(cells, fit.p, fit.noise, p_min), 1e-9 * total);
    EXPECT_LE(fit.gap, 1e-7 * total) << "problem " << problem;
    // The certificate again, from its definition: no vertex of the simplex is uphill.
    for (int i = 0; i <= outcomes; ++i) {
      double slope = 0;
      for (const auto& cell : cells) {
        double likelihood = p_min * fit.noise;
        for (const int o : cell.outcomes) likelihood += fit.p[static_cast<std::size_t>(o)];
        const bool has = std::find(cell.outcomes.begin(), cell.outcomes.end(), i) != cell.outcomes.end();
        slope += cell.weight * (i == outcomes ? p_min : has ? 1.0 : 0.0) / likelihood;
      }
      EXPECT_LE(slope - total, 1e-7 * total) << "problem " << problem << " outcome " << i;
    }
  }
}

}  // namespace
}  // namespace primo::rules
