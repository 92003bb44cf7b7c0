#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "core/random.h"
#include "functions.h"
#include "optim/boundary.h"
#include "optim/cma_parameters.h"
#include "optim/descent.h"

namespace primo::optim {
namespace {

using test::box;
using test::make;

int median_evaluations(const test::Cost& cost, double target, int d, int budget) {
  std::vector<int> runs;
  for (std::uint64_t seed = 1; seed <= 15; ++seed) {
    // x0 in [−4, 4] and a step of 2, as in published comparisons.
    runs.push_back(test::evaluations_to(
        cost, target, {.name = "cma", .evaluations = budget, .sigma = 0.25, .seed = seed}, box(d, -4, 4)));
  }
  std::sort(runs.begin(), runs.end());
  testing::Test::RecordProperty("median", runs[runs.size() / 2]);
  return runs[runs.size() / 2];
}

// Median evaluations of other implementations over 15 runs: 1444 to 1463 (sphere), 3914 to 7722 (ellipsoid), 5015 to
// 6160 (Rosenbrock; a median of 15 runs varies by some 200 there).
TEST(Cma, minimises_the_sphere_as_fast_as_its_peers) {
  EXPECT_LE(median_evaluations(test::function("sphere"), 1e-8, 10, 10000), 1500);
}
TEST(Cma, minimises_the_ellipsoid_as_fast_as_its_peers) {
  EXPECT_LE(median_evaluations(test::function("ellipsoid"), 1e-8, 10, 20000), 4200);
}
TEST(Cma, minimises_the_rosenbrock_function_as_fast_as_its_peers) {
  EXPECT_LE(median_evaluations(test::function("rosenbrock"), 1e-8, 10, 20000), 5600);
}

TEST(Cma, reaches_an_optimum_on_the_boundary) {
  // The ellipsoid about (1, …, 1) in a box that ends at 0: the optimum is the corner, where the cost is Σ weights.
  const auto shifted = [](std::vector<double> x) {
    for (auto& value : x) value -= 1;
    return test::function("ellipsoid")(x);
  };
  const double optimum = test::function("ellipsoid")(std::vector<double>(6, 1.0));
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    const auto optimizer = make({.name = "cma", .evaluations = 6000, .seed = seed}, box(6, -4, 0));
    while (!optimizer->done()) {
      for (const auto& candidate : optimizer->ask()) {
        for (const double value : candidate.x) ASSERT_TRUE(value >= -4 && value <= 0) << value;
        ASSERT_TRUE(optimizer->tell(candidate.generation, candidate.index, -shifted(candidate.x)).ok());
      }
    }
    EXPECT_LT(shifted(optimizer->recommendation()) - optimum, 1e-6 * optimum) << "seed " << seed;
    for (const double value : optimizer->recommendation()) EXPECT_TRUE(value >= -4 && value <= 0);
  }
}

TEST(Cma, weights_follow_the_equations_of_the_tutorial) {
  const CmaParameters p(10, 10);
  EXPECT_EQ(p.mu, 5);
  EXPECT_NEAR(p.weights.head(5).sum(), 1, 1e-14);
  EXPECT_NEAR(p.weights[0] / p.weights[1], std::log(5.5) / std::log(5.5 / 2), 1e-12);
  EXPECT_NEAR(p.mu_eff, 1 / p.weights.head(5).squaredNorm(), 1e-12);
  EXPECT_LT(p.weights.tail(5).maxCoeff(), 0);
  // Equation 53: at most min(α_μ⁻, α_μeff⁻, α_posdef⁻) in sum.
  EXPECT_LE(-p.weights.tail(5).sum(), (1 - p.c_1 - p.c_mu) / (10 * p.c_mu) + 1e-12);
  EXPECT_LE(-p.weights.tail(5).sum(), 1 + p.c_1 / p.c_mu + 1e-12);
}

TEST(BoundaryPenalty, is_zero_inside_and_grows_with_the_distance_outside) {
  BoundaryPenalty penalty(2);
  const Eigen::VectorXd diagonal = Eigen::VectorXd::Ones(2);
  const Eigen::Vector2d inside(0.5, 1.0), near(0.5, 1.1), far(0.5, 1.3);
  penalty.adapt({0, 1, 2, 3, 4, 5, 6, 7}, inside, 0.1, diagonal, 3);
  EXPECT_EQ(penalty(far, diagonal), 0) << "no penalty before the mean has left the box";
  penalty.adapt({0, 1, 2, 3, 4, 5, 6, 7}, near, 0.1, diagonal, 3);
  EXPECT_EQ(penalty(inside, diagonal), 0);
  // The spread (interquartile range) is 4: γ = 2·4/0.1² = 800; penalty = γ·distance²/n.
  EXPECT_NEAR(penalty(near, diagonal), 800 * 0.01 / 2, 1e-9);
  EXPECT_NEAR(penalty(far, diagonal), 800 * 0.09 / 2, 1e-9);
}

TEST(Cma, finds_a_small_region_of_success_when_the_fitness_has_two_values) {
  // Success within 0.25 of the centre, else failure: half of the candidates tell nothing.
  int found = 0;
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    const auto binary = [](const std::vector<double>& x) {
      return std::all_of(x.begin(), x.end(), [](double v) { return std::abs(v - 0.5) < 0.25; }) ? 1.0 : 0.0;
    };
    const auto optimizer = make({.name = "cma", .evaluations = 2000, .seed = seed}, box(4, 0, 1));
    while (!optimizer->done()) {
      for (const auto& c : optimizer->ask()) ASSERT_TRUE(optimizer->tell(c.generation, c.index, binary(c.x)).ok());
    }
    found += binary(optimizer->recommendation()) > 0;
  }
  EXPECT_GE(found, 9);
}

}  // namespace
}  // namespace primo::optim
