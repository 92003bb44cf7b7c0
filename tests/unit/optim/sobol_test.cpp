#include <gtest/gtest.h>

#include <cmath>
#include <set>

#include "core/random.h"
#include "functions.h"
#include "optim/sobol_sequence.h"

namespace primo::optim {
namespace {

TEST(SobolSequence, fills_every_coordinate_evenly_in_each_aligned_block) {
  // Every coordinate is a (0, 1)-sequence in base 2: of 2^m points from a multiple of 2^m on, each interval of length
  // 2^−m has one.
  const SobolSequence sequence(40);
  for (const int m : {1, 4, 8}) {
    const std::uint32_t size = 1U << m;
    for (const std::uint32_t block : {0U, 1U, 5U}) {
      std::vector<std::set<std::uint32_t>> seen(40);
      for (std::uint32_t n = block * size; n < (block + 1) * size; ++n) {
        const auto x = sequence.point(n);
        for (std::size_t i = 0; i < 40; ++i) seen[i].insert(x[i] >> (32 - m));
      }
      for (std::size_t i = 0; i < 40; ++i) EXPECT_EQ(seen[i].size(), size) << "coordinate " << i << ", 2^" << m;
    }
  }
}

TEST(SobolSequence, has_one_of_the_first_2_to_the_d_points_in_each_orthant) {
  for (const int d : {2, 5, 8, 12}) {
    const SobolSequence sequence(d);
    std::set<std::uint32_t> orthants;
    for (std::uint32_t n = 0; n < 1U << d; ++n) {
      std::uint32_t orthant = 0;
      for (const std::uint32_t x : sequence.point(n)) orthant = orthant << 1 | x >> 31;
      orthants.insert(orthant);
    }
    EXPECT_EQ(orthants.size(), std::size_t{1} << d) << d;
  }
}

TEST(SobolSequence, of_two_coordinates_is_a_net_of_the_best_quality) {
  // The first two coordinates form a (0, m, 2)-net: each of the 2^m boxes of area 2^−m, of any shape, holds one point.
  const SobolSequence sequence(2);
  const int m = 8;
  for (int a = 0; a <= m; ++a) {
    std::set<std::pair<std::uint64_t, std::uint64_t>> boxes;
    for (std::uint32_t n = 0; n < 1U << m; ++n) {
      const auto x = sequence.point(n);
      boxes.insert({std::uint64_t{x[0]} >> (32 - a), std::uint64_t{x[1]} >> (32 - (m - a))});
    }
    EXPECT_EQ(boxes.size(), std::size_t{1} << m) << a;
  }
}

TEST(Sobol, integrates_a_smooth_function_much_better_than_random_points) {
  // ∫ Π (1 + (x_i − ½)/2) = 1 over the unit box.
  const auto error = [](const char* name) {
    double sum = 0;
    for (std::uint64_t seed = 1; seed <= 20; ++seed) {
      const auto optimizer =
          test::make({.name = name, .evaluations = 1024, .population = 1024, .seed = seed}, test::box(6, 0, 1));
      double integral = 0;
      for (const auto& c : optimizer->ask()) {
        double product = 1;
        for (const double x : c.x) product *= 1 + (x - 0.5) / 2;
        integral += product / 1024;
      }
      sum += (integral - 1) * (integral - 1) / 20;
    }
    return std::sqrt(sum);
  };
  EXPECT_LT(error("sobol"), error("monte_carlo") / 10);
}

TEST(Sobol, gives_the_same_points_whatever_the_size_of_a_generation) {
  for (const char* name : {"sobol", "monte_carlo"}) {
    std::vector<std::vector<double>> points[2];
    for (const int i : {0, 1}) {
      const auto optimizer =
          test::make({.name = name, .evaluations = 100, .population = i == 0 ? 7 : 30}, test::box(3, -1, 1));
      while (!optimizer->done()) {
        for (const auto& c : optimizer->ask()) {
          points[i].push_back(c.x);
          ASSERT_TRUE(optimizer->tell(c.generation, c.index, 0).ok());
        }
      }
    }
    EXPECT_EQ(points[0], points[1]) << name;
  }
}

TEST(DifferentialEvolution, minimises_functions_that_are_separable_or_have_many_hollows) {
  for (const char* function : {"sphere", "ellipsoid", "rastrigin"}) {
    for (std::uint64_t seed = 1; seed <= 5; ++seed) {
      const int evaluations = test::evaluations_to(
          test::function(function), 1e-8, {.name = "differential_evolution", .evaluations = 60000, .seed = seed},
          test::box(5, -5, 4));
      EXPECT_LT(evaluations, 60000) << function << ", seed " << seed;
    }
  }
}

}  // namespace
}  // namespace primo::optim
