// Evaluations that each optimizer needs to reach a target on standard functions (median over 15 runs; x0 in [−4, 4], σ
// = 2), and what its own work costs.
#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <functional>
#include <nlohmann/json.hpp>

#include "optim/optimizer.h"

namespace {

using Point = std::vector<double>;

double sphere(const Point& x) {
  double sum = 0;
  for (const double v : x) sum += v * v;
  return sum;
}
double ellipsoid(const Point& x) {
  double sum = 0;
  for (std::size_t i = 0; i < x.size(); ++i) {
    sum += std::pow(1e6, static_cast<double>(i) / static_cast<double>(x.size() - 1)) * x[i] * x[i];
  }
  return sum;
}
double rosenbrock(const Point& x) {
  double sum = 0;
  for (std::size_t i = 0; i + 1 < x.size(); ++i) {
    sum += 100 * std::pow(x[i + 1] - x[i] * x[i], 2) + std::pow(1 - x[i], 2);
  }
  return sum;
}

nlohmann::ordered_json measure(const std::string& optimizer, const char* name, double (*cost)(const Point&), int d,
                               double target, int budget) {
  std::vector<int> runs;
  int reached = 0, evaluations = 0;
  const auto begin = std::chrono::steady_clock::now();
  for (std::uint64_t seed = 1; seed <= 15; ++seed) {
    const primo::optim::Bounds bounds{Point(static_cast<std::size_t>(d), -4.0),
                                      Point(static_cast<std::size_t>(d), 4.0)};
    auto made =
        primo::optim::make_optimizer({.name = optimizer, .evaluations = budget, .sigma = 0.25, .seed = seed}, bounds);
    const auto run = std::move(made).value();
    bool hit = false;
    while (!hit && !run->done()) {
      for (const auto& candidate : run->ask()) {
        const double value = cost(candidate.x);
        if (!run->tell(candidate.generation, candidate.index, -value).ok()) return {};
        if ((hit = value <= target)) break;
      }
    }
    reached += hit;
    evaluations += run->evaluations();
    runs.push_back(hit ? run->evaluations() : budget);
  }
  const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  std::sort(runs.begin(), runs.end());
  return {{"optimizer", optimizer},
          {"function", name},
          {"dimension", d},
          {"target", target},
          {"median_evaluations", runs[7]},
          {"quartiles", {runs[3], runs[11]}},
          {"reached", reached},
          {"microseconds_per_evaluation", 1e6 * seconds / evaluations}};
}

}  // namespace

int main() {
  nlohmann::ordered_json results = nlohmann::ordered_json::array();
  for (const int d : {10, 20}) {
    results.push_back(measure("cma", "sphere", sphere, d, 1e-8, 20000));
    results.push_back(measure("cma", "ellipsoid", ellipsoid, d, 1e-8, 60000));
    results.push_back(measure("cma", "rosenbrock", rosenbrock, d, 1e-8, 80000));
  }
  results.push_back(measure("monte_carlo", "sphere", sphere, 4, 1, 20000));
  results.push_back(measure("cma", "sphere", sphere, 4, 1, 20000));
  std::printf("%s\n", nlohmann::ordered_json{{"bench", "optimizer"}, {"results", results}}.dump(1).c_str());
}
