// The optimizers' factories; a new optimizer is a file with one, and a line in the table of optimizers.cpp.
#pragma once

#include <memory>

#include "optim/optimizer.h"

namespace primo::optim {

/// Settings and bounds are checked already: d ≥ 1 finite bounds, lower < upper.
std::unique_ptr<Optimizer> make_cma(const OptimizerSettings& settings, const Bounds& bounds);
std::unique_ptr<Optimizer> make_monte_carlo(const OptimizerSettings& settings, const Bounds& bounds);

/// The population of both by default: 4 + ⌊3 ln d⌋ (Hansen, arXiv 1604.00772, table 1).
int default_population(std::size_t dimension);

}  // namespace primo::optim
