// The functions that optimizers are compared on, with minimum 0: Hansen, Finck, Ros and Auger, Real-Parameter Black-Box
// Optimization Benchmarking 2009: Noiseless Functions Definitions (INRIA RR-6829), without rotation and shift.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "core/result.h"

namespace primo::optim {

struct TestFunction {
  const char* name;
  double (*cost)(std::span<const double> x);
  double lower, upper;  ///< of every coordinate, as published comparisons have it
  const char* text;
};

/// The table of test functions.
std::span<const TestFunction> test_functions();
/// Error (usage): no function of this name; lists the known ones.
Result<const TestFunction*> find_test_function(const std::string& name);

}  // namespace primo::optim
