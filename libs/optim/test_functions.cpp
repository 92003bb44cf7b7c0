#include "optim/test_functions.h"

#include <cmath>
#include <numbers>

#include "config/config.h"

namespace primo::optim {
namespace {

double sphere(std::span<const double> x) {
  double sum = 0;
  for (const double v : x) sum += v * v;
  return sum;
}

double ellipsoid(std::span<const double> x) {
  double sum = 0;
  for (std::size_t i = 0; i < x.size(); ++i) {
    const double exponent = x.size() > 1 ? static_cast<double>(i) / static_cast<double>(x.size() - 1) : 0;
    sum += std::pow(1e6, exponent) * x[i] * x[i];
  }
  return sum;
}

double rosenbrock(std::span<const double> x) {
  if (x.size() == 1) return (1 - x[0]) * (1 - x[0]);
  double sum = 0;
  for (std::size_t i = 0; i + 1 < x.size(); ++i) {
    const double valley = x[i + 1] - x[i] * x[i], along = 1 - x[i];
    sum += 100 * valley * valley + along * along;
  }
  return sum;
}

double rastrigin(std::span<const double> x) {
  double sum = 0;
  for (const double v : x) sum += v * v + 10 * (1 - std::cos(2 * std::numbers::pi * v));
  return sum;
}

constexpr TestFunction kFunctions[] = {
    {"sphere", sphere, -4, 4, "sum of squares"},
    {"ellipsoid", ellipsoid, -4, 4, "squares weighted from 1 to 1e6"},
    {"rosenbrock", rosenbrock, -4, 4, "a bent valley to (1, ..., 1)"},
    {"rastrigin", rastrigin, -5, 5, "a bowl with 10^d hollows"},
};

}  // namespace

std::span<const TestFunction> test_functions() { return kFunctions; }

Result<const TestFunction*> find_test_function(const std::string& name) {
  std::vector<std::string> known;
  for (const auto& function : kFunctions) {
    if (name == function.name) return &function;
    known.emplace_back(function.name);
  }
  return Error{Code::usage, "no problem is named \"" + name + "\"; known: " + config::detail::joined(known)};
}

}  // namespace primo::optim
