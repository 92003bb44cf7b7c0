#include <gtest/gtest.h>

#include <Eigen/QR>
#include <algorithm>
#include <cmath>

#include "core/random.h"
#include "functions.h"
#include "optim/boundary.h"
#include "optim/cma_parameters.h"
#include "optim/descent.h"
#include "optim/patience.h"
#include "optim/restarts.h"

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
// 6160 (Rosenbrock).
TEST(Cma, minimises_the_sphere_as_fast_as_its_peers) {
  EXPECT_LE(median_evaluations(test::function("sphere"), 1e-8, 10, 10000), 1500);
}
TEST(Cma, minimises_the_ellipsoid_as_fast_as_its_peers) {
  EXPECT_LE(median_evaluations(test::function("ellipsoid"), 1e-8, 10, 20000), 4200);
}
TEST(Cma, minimises_the_rosenbrock_function_as_fast_as_its_peers) {
  EXPECT_LE(median_evaluations(test::function("rosenbrock"), 1e-8, 10, 20000), 5200);
}

TEST(Cma, reaches_an_optimum_on_the_boundary) {
  // The ellipsoid about (1, …, 1) in a box that ends at 0: the optimum is the corner, where the cost is Σ weights.
  const auto shifted = [](std::vector<double> x) {
    for (auto& value : x) value -= 1;
    return test::function("ellipsoid")(x);
  };
  const double optimum = test::function("ellipsoid")(std::vector<double>(6, 1.0));
  for (std::uint64_t seed = 1; seed <= 15; ++seed) {
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

TEST(Cma, samples_have_the_distribution_s_mean_and_covariance) {
  // The state is given: N(m, σ²C) with C = B D² Bᵀ, far inside the box, so that nothing is repaired.
  const int n = 4;
  Random random(3, "covariance");
  Eigen::MatrixXd A(n, n);
  for (auto& a : A.reshaped()) a = random.normal();
  const Eigen::MatrixXd B = Eigen::HouseholderQR<Eigen::MatrixXd>(A).householderQ();
  const Eigen::VectorXd D = Eigen::Vector4d(0.3, 0.7, 1.5, 3);
  const Eigen::MatrixXd C = B * D.cwiseAbs2().asDiagonal() * B.transpose();
  const double sigma = 0.02;
  Eigen::VectorXd sum = Eigen::VectorXd::Zero(n);
  Eigen::MatrixXd squares = Eigen::MatrixXd::Zero(n, n);
  int count = 0;
  for (std::uint64_t seed = 1; seed <= 2500; ++seed) {
    const auto optimizer = make({.name = "cma", .seed = seed}, box(n, 0, 1));
    State state = optimizer->state();
    state["mean"] = {0.5, 0.5, 0.5, 0.5};
    state["sigma"] = {sigma};
    state["B"] = flat(B);
    state["C"] = flat(C);
    state["D"] = flat(D);
    ASSERT_TRUE(optimizer->restore(state).ok());
    for (const auto& candidate : optimizer->ask()) {
      const Eigen::VectorXd y = (Eigen::Map<const Eigen::VectorXd>(candidate.x.data(), n).array() - 0.5) / sigma;
      sum += y;
      squares += y * y.transpose();
      ++count;
    }
  }
  ASSERT_EQ(count, 2500 * 8);
  // Standard errors: √(C_ii/N) of a mean, √((C_ii C_jj + C_ij²)/N) of a covariance; five of them.
  for (int i = 0; i < n; ++i) {
    EXPECT_NEAR(sum[i] / count, 0, 5 * std::sqrt(C(i, i) / count));
    for (int j = 0; j < n; ++j) {
      EXPECT_NEAR(squares(i, j) / count, C(i, j), 5 * std::sqrt((C(i, i) * C(j, j) + C(i, j) * C(i, j)) / count));
    }
  }
}

TEST(Cma, candidates_of_a_generation_look_into_directions_at_right_angles) {
  const auto optimizer = make({.name = "cma", .population = 10, .sigma = 0.01, .seed = 9}, box(5, 0, 1));
  State state = optimizer->state();
  state["mean"] = {0.5, 0.5, 0.5, 0.5, 0.5};
  ASSERT_TRUE(optimizer->restore(state).ok());
  std::vector<Eigen::VectorXd> z;
  for (const auto& c : optimizer->ask())
    z.push_back((Eigen::Map<const Eigen::VectorXd>(c.x.data(), 5).array() - 0.5) / 0.01);
  for (std::size_t i = 0; i < 10; ++i) {
    for (std::size_t j = 0; j < i; ++j) {
      const double cosine = z[i].dot(z[j]) / (z[i].norm() * z[j].norm());
      if (i / 5 == j / 5) {
        EXPECT_NEAR(cosine, 0, 1e-9) << i << " " << j;
      } else {
        EXPECT_GT(std::abs(cosine), 1e-9) << "another block has its own directions";
      }
    }
  }
}

TEST(Descent, under_random_selection_the_path_has_the_expected_length_and_the_step_size_does_not_drift) {
  // Equation 43 makes p_σ ~ N(0, I) when selection is random: E‖p_σ‖² = n, and ln σ is a martingale up to the
  // curvature of its update. C is held at I by telling costs of independent noise to many short descents.
  const int n = 8, lambda = 10;
  Random random(17, "noise");
  double squares = 0, log_sigma = 0, log_squares = 0;
  const int runs = 1500, generations = 12;
  for (int run = 0; run < runs; ++run) {
    Descent descent(n, lambda, Eigen::VectorXd::Constant(n, 0.5), 1e-3);
    for (int g = 0; g < generations; ++g) {
      std::vector<Eigen::VectorXd> z(lambda, Eigen::VectorXd(n));
      std::vector<double> costs;
      for (auto& one : z) {
        for (auto& coordinate : one) coordinate = random.normal();
        costs.push_back(random.uniform());
      }
      descent.update(z, costs);
    }
    // The path of g generations has variance 1 − (1 − c_σ)^(2g).
    const double variance = 1 - std::pow(1 - descent.p.c_sigma, 2.0 * generations);
    squares += descent.path_sigma.squaredNorm() / (variance * runs);
    const double drift = std::log(descent.sigma / 1e-3);
    log_sigma += drift / runs;
    log_squares += drift * drift / runs;
  }
  // ‖p_σ‖² is χ²(n): variance 2n.
  EXPECT_NEAR(squares, n, 5 * std::sqrt(2.0 * n / runs));
  // Of the first generations the path is shorter than E‖N(0, I)‖, so σ falls a little: by Σ c_σ/d_σ (1 − √(1 − (1 −
  // c_σ)^(2g))).
  const CmaParameters p(n, lambda);
  double expected = 0;
  for (int g = 1; g <= generations; ++g)
    expected += p.c_sigma / p.d_sigma * (std::sqrt(1 - std::pow(1 - p.c_sigma, 2.0 * g)) - 1);
  EXPECT_NEAR(log_sigma, expected, 5 * std::sqrt((log_squares - log_sigma * log_sigma) / runs) + 0.01);
}

TEST(Descent, on_a_rotated_function_takes_the_rotated_steps) {
  // The update is equivariant: with z rotated and the costs the same, mean and C are rotated and σ is the same.
  const int n = 6, lambda = 9;
  Random random(23, "rotation");
  Eigen::MatrixXd A(n, n);
  for (auto& a : A.reshaped()) a = random.normal();
  const Eigen::MatrixXd R = Eigen::HouseholderQR<Eigen::MatrixXd>(A).householderQ();
  const Eigen::VectorXd centre = Eigen::VectorXd::Constant(n, 0.5);
  Descent plain(n, lambda, centre, 1e-3), rotated(n, lambda, centre, 1e-3);
  const auto cost = [&](const Eigen::VectorXd& x) {
    double sum = 0;
    for (int i = 0; i < n; ++i) sum += std::pow(100.0, i) * std::pow(x[i] - 0.501, 2);
    return sum;
  };
  for (int g = 0; g < 60; ++g) {
    std::vector<Eigen::VectorXd> z, z_rotated;
    std::vector<double> costs;
    for (int k = 0; k < lambda; ++k) {
      Eigen::VectorXd one(n);
      for (auto& coordinate : one) coordinate = random.normal();
      costs.push_back(cost(plain.point(one)));
      // The same point in the other frame: R (x − centre) = σ B' D' z' with the rotated descent's own B' D'.
      const Eigen::VectorXd step = R * (plain.point(one) - centre) - (rotated.mean - centre);
      z_rotated.push_back((rotated.B.transpose() * step).cwiseQuotient(rotated.D) / rotated.sigma);
      z.push_back(one);
    }
    plain.update(z, costs);
    rotated.update(z_rotated, costs);
  }
  EXPECT_NEAR(rotated.sigma / plain.sigma, 1, 1e-6);
  EXPECT_LT((rotated.mean - centre - R * (plain.mean - centre)).norm(), 1e-6 * (plain.mean - centre).norm());
  EXPECT_LT((rotated.C - R * plain.C * R.transpose()).norm(), 1e-6 * plain.C.norm());
  EXPECT_GT(plain.condition(), 10) << "it has learned something";
}

TEST(Descent, is_the_same_for_costs_of_the_same_order) {
  // Only ranks count: any rising function of the cost gives the same run, bit for bit. Inside the box: no penalty.
  const auto bowl = test::function("ellipsoid");
  const auto plain = make({.name = "cma", .evaluations = 2000, .sigma = 0.02, .seed = 5}, box(5, -40, 40));
  const auto bent = make({.name = "cma", .evaluations = 2000, .sigma = 0.02, .seed = 5}, box(5, -40, 40));
  State start = plain->state();
  start["mean"] = {0.4, 0.6, 0.5, 0.45, 0.55};
  ASSERT_TRUE(plain->restore(start).ok() && bent->restore(start).ok());
  for (int g = 0; g < 100; ++g) {
    test::generation(*plain, bowl);
    test::generation(*bent, [&](const std::vector<double>& x) { return std::atan(std::sqrt(bowl(x)) / 100); });
    ASSERT_EQ(plain->ask()[0].x, bent->ask()[0].x) << g;
  }
}

TEST(Restarts, double_the_population_after_each_stagnation) {
  OptimizerSettings settings;
  Restarts ipop(settings, 8);
  for (const int population : {16, 32, 64}) {
    ASSERT_TRUE(ipop.next(1000));
    EXPECT_EQ(ipop.plan().population, population);
    EXPECT_EQ(ipop.plan().sigma, settings.sigma);
  }
  EXPECT_EQ(ipop.count(), 3);
  settings.on_stagnation = "again";
  Restarts again(settings, 8);
  ASSERT_TRUE(again.next(1000));
  EXPECT_EQ(again.plan().population, 8);
  settings.on_stagnation = "stop";
  EXPECT_FALSE(Restarts(settings, 8).next(1000));
}

TEST(Restarts, of_two_populations_give_the_small_ones_no_more_than_the_large_ones) {
  OptimizerSettings settings;
  settings.on_stagnation = "bipop";
  Restarts restarts(settings, 8);
  int large = 0, small = 0, large_population = 8, smalls = 0;
  bool is_small = false;
  for (int descent = 0; descent < 60; ++descent) {
    const auto plan = restarts.plan();
    const int spent = std::min(plan.limit, 100 * plan.population);
    (is_small ? small : large) += spent;
    if (is_small) {
      ++smalls;
      EXPECT_GE(plan.population, 8);
      EXPECT_LE(plan.population, large_population / 2);
      EXPECT_LE(plan.sigma, settings.sigma);
      EXPECT_GE(plan.sigma, settings.sigma / 100);
    } else {
      EXPECT_EQ(plan.population, large_population);
      EXPECT_EQ(plan.sigma, settings.sigma);
    }
    ASSERT_TRUE(restarts.next(spent));
    is_small = small < large && descent > 0;
    if (!is_small) large_population *= 2;
    if (large_population > 1 << 15) break;
  }
  EXPECT_GT(smalls, 10);
}

TEST(Cma, finds_the_deepest_hollow_by_restarting_with_larger_populations) {
  for (const char* rule : {"ipop", "bipop"}) {
    int found = 0;
    for (std::uint64_t seed = 1; seed <= 5; ++seed) {
      const OptimizerSettings settings{.evaluations = 60000, .sigma = 0.25, .seed = seed, .on_stagnation = rule};
      found += test::evaluations_to(test::function("rastrigin"), 1e-8, settings, box(4, -5, 5)) < 60000;
    }
    EXPECT_GE(found, 4) << rule;
  }
  const auto once = make({.evaluations = 60000, .sigma = 0.25, .on_stagnation = "stop"}, box(4, -5, 5));
  test::run(*once, test::function("rastrigin"));
  EXPECT_TRUE(once->stagnated());
  EXPECT_NE(once->stop_reason().find("stagnated"), std::string::npos);
  EXPECT_LT(once->evaluations(), 60000);
}

TEST(Patience, ends_when_neither_the_best_nor_the_mean_has_risen_for_so_many_generations) {
  Patience patience(3, 0.5);
  const auto ended_after = [&](const std::vector<std::vector<double>>& generations) {
    patience.reset();
    std::size_t n = 0;
    while (n < generations.size() && !patience.over()) patience.add(generations[n++]);
    return patience.over() ? n : 0;
  };
  EXPECT_EQ(ended_after({{2, 4}, {2, 4}, {2, 4}, {2, 4}}), 4u) << "the first one is a rise from nothing";
  EXPECT_EQ(ended_after({{2, 4}, {2, 4}, {2, 4}, {1.4, 4}, {2, 4}, {2, 4}}), 0u) << "the best rose in time";
  EXPECT_EQ(ended_after({{2, 4}, {2, 4}, {2, 4}, {2, 2.9}, {2, 4}, {2, 4}}), 0u) << "the mean rose in time";
  EXPECT_EQ(ended_after({{2, 4}, {1.6, 4}, {1.6, 4}, {1.6, 4}}), 4u) << "0.4 is no rise";
  EXPECT_EQ(ended_after({{2, 4}, {1.6, 4}, {1.4, 4}, {1.6, 4}}), 0u) << "two small steps are one";
}

TEST(Patience, leaves_a_noisy_plateau_from_which_no_criterion_without_noise_would_go) {
  // Only a corner of the box counts; elsewhere there is noise alone, which no two generations share.
  int draw = 0;
  const auto fitness = [&](const std::vector<double>& x) {
    double far = 0;
    for (const double v : x) far = std::max(far, 1 - v);
    return far < 0.7 ? 1 - far : 0.001 * Random(7, "noise", {static_cast<std::uint64_t>(++draw)}).uniform();
  };
  int without = 0, with = 0;
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    for (const int generations : {0, 15}) {
      const auto cma = make({.name = "cma",
                             .evaluations = 1000,
                             .population = 10,
                             .sigma = 0.02,
                             .seed = seed,
                             .on_stagnation = "again",
                             .patience = generations},
                            box(3, 0, 1));
      while (!cma->done()) {
        const auto candidates = cma->ask();
        for (const auto& c : candidates) ASSERT_TRUE(cma->tell(c.generation, c.index, fitness(c.x)).ok());
      }
      (generations > 0 ? with : without) += cma->best_fitness() > 0.9;
    }
  }
  EXPECT_GE(with, without + 4);
  EXPECT_GE(with, 17);
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

TEST(BoundaryPenalty, falls_to_that_of_a_new_weight_when_costs_differ_less) {
  BoundaryPenalty penalty(2);
  const Eigen::VectorXd diagonal = Eigen::VectorXd::Ones(2);
  const Eigen::Vector2d near(0.5, 1.1);
  penalty.adapt({0, 1, 2, 3, 4, 5, 6, 7}, near, 0.1, diagonal, 3);
  const double before = penalty(near, diagonal);
  for (int generation = 0; generation < 100; ++generation) {
    penalty.adapt({0, 1e-3, 2e-3, 3e-3, 4e-3, 5e-3, 6e-3, 7e-3}, near, 0.1, diagonal, 3);
  }
  // Not below the new weight 2·0.004/0.1² but for the last step of the decay.
  EXPECT_LE(penalty(near, diagonal), before * 1e-3 * (1 + 1e-9));
  EXPECT_GE(penalty(near, diagonal), before * 1e-3 * 0.5);
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
