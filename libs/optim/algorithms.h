// The optimizers' factories; a new optimizer is a file with one, and a line in the table of optimizers.cpp.
#pragma once

#include <memory>

#include "optim/optimizer.h"

namespace primo::optim {

/// Settings and bounds are checked already: d ≥ 1 finite bounds, lower < upper, a budget of at least one generation.
std::unique_ptr<Optimizer> make_cma(const OptimizerSettings& settings, const Bounds& bounds);
std::unique_ptr<Optimizer> make_differential_evolution(const OptimizerSettings& settings, const Bounds& bounds);
std::unique_ptr<Optimizer> make_monte_carlo(const OptimizerSettings& settings, const Bounds& bounds);
std::unique_ptr<Optimizer> make_sobol(const OptimizerSettings& settings, const Bounds& bounds);

/// Populations where the settings leave them open. CMA-ES: 4 + ⌊3 ln d⌋ (Hansen, arXiv 1604.00772, table 1); Monte
/// Carlo and Sobol, where the size of a generation means nothing, the same.
int default_population(std::size_t dimension);
/// Differential evolution: 5 d, at least 10 and at most 200 (Storn and Price say 5 d to 10 d).
int default_evolution_population(std::size_t dimension);

}  // namespace primo::optim
