// A peer: the cmaes of Debian's libpagmo-dev, where it is installed. pagmo is no dependency of primo.
#pragma once

#ifdef PRIMO_WITH_PAGMO
#include <pagmo/algorithm.hpp>
#include <pagmo/algorithms/cmaes.hpp>
#include <pagmo/population.hpp>
#include <pagmo/problem.hpp>
#include <span>
#include <vector>

namespace primo::bench {

/// Counts the evaluations until the target was reached.
struct Counter {
  double (*cost)(std::span<const double>) = nullptr;
  double target = 0;
  long evaluations = 0, reached_after = 0;  // 0: not reached
};

struct PagmoProblem {
  Counter* counter = nullptr;
  double lower = -1, upper = 1;
  std::size_t dimension = 1;
  pagmo::vector_double fitness(const pagmo::vector_double& x) const {
    const double value = counter->cost(x);
    ++counter->evaluations;
    if (counter->reached_after == 0 && value <= counter->target) counter->reached_after = counter->evaluations;
    return {value};
  }
  std::pair<pagmo::vector_double, pagmo::vector_double> get_bounds() const {
    return {pagmo::vector_double(dimension, lower), pagmo::vector_double(dimension, upper)};
  }
};

/// Evaluations to the target with σ = `sigma` from a random start in the box; the budget when it is not reached.
inline int pagmo_evaluations(double (*cost)(std::span<const double>), double lower, double upper, int dimension,
                             double target, int budget, double sigma, unsigned seed, bool& reached) {
  Counter counter{cost, target};
  PagmoProblem problem;
  problem.counter = &counter;
  problem.lower = lower;
  problem.upper = upper;
  problem.dimension = static_cast<std::size_t>(dimension);
  const auto population = static_cast<unsigned>(4 + static_cast<int>(3 * std::log(dimension)));
  pagmo::population start(pagmo::problem{problem}, population, seed);
  // pagmo's own defaults but for the step, and without its stop on flat fitness.
  pagmo::algorithm cmaes{pagmo::cmaes(static_cast<unsigned>(budget) / population, -1, -1, -1, -1, sigma, 1e-300, 1e-300,
                                      false, true, seed)};
  cmaes.evolve(start);
  reached = counter.reached_after > 0;
  return reached ? static_cast<int>(counter.reached_after) : budget;
}

}  // namespace primo::bench
#endif
