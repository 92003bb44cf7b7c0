// Evaluations that each optimizer needs to reach a target on standard functions (median over 15 runs; x0 in [−4, 4], σ
// = 2), with and without the optimum on a bound, and what its own work costs. pagmo's cmaes beside it where installed.
#include <CLI/CLI.hpp>
#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <functional>
#include <nlohmann/json.hpp>

#include "bench/pagmo_cmaes.h"
#include "optim/optimizer.h"
#include "optim/test_functions.h"

namespace {

using Point = std::vector<double>;
using Cost = std::function<double(const Point&)>;
using Json = nlohmann::ordered_json;
using namespace primo::optim;

constexpr int kRuns = 15;

struct Case {
  std::string optimizer, function;
  int dimension;
  double target;
  int budget;
};

/// 15 runs as one line: `run(seed, reached)` gives the evaluations.
Json summary(const Case& c, const std::function<int(std::uint64_t, bool&)>& run) {
  std::vector<int> runs;
  int reached = 0;
  double evaluations = 0;
  const auto begin = std::chrono::steady_clock::now();
  for (std::uint64_t seed = 1; seed <= kRuns; ++seed) {
    bool hit = false;
    runs.push_back(run(seed, hit));
    reached += hit;
    evaluations += runs.back();
  }
  const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  std::sort(runs.begin(), runs.end());
  Json line = {{"optimizer", c.optimizer},
               {"function", c.function},
               {"dimension", c.dimension},
               {"target", c.target},
               {"median_evaluations", runs[7]},
               {"quartiles", {runs[3], runs[11]}},
               {"reached", reached},
               {"runs", kRuns},
               {"microseconds_per_evaluation", 1e6 * seconds / evaluations}};
  std::fprintf(stderr, "%s\n", line.dump().c_str());
  return line;
}

Json measure(const Case& c, const Bounds& bounds, const Cost& cost) {
  return summary(c, [&](std::uint64_t seed, bool& hit) {
    auto run =
        make_optimizer({.name = c.optimizer, .evaluations = c.budget, .sigma = 0.25, .seed = seed}, bounds).value();
    while (!run->done()) {
      for (const auto& candidate : run->ask()) {
        const double value = cost(candidate.x);
        if (!run->tell(candidate.generation, candidate.index, -value).ok()) return c.budget;
        hit = value <= c.target;
        if (hit) return run->evaluations();
      }
    }
    return c.budget;
  });
}

Bounds box(int d, double lower, double upper) {
  return {Point(static_cast<std::size_t>(d), lower), Point(static_cast<std::size_t>(d), upper)};
}

Json on_function(const Case& c) {
  const auto* function = find_test_function(c.function).value();
  return measure(c, box(c.dimension, function->lower, function->upper),
                 [=](const Point& x) { return function->cost(x); });
}

/// The function about (1, …, 1) in a box that ends at 0: the optimum is the corner. The cost is that above the
/// corner's.
Json on_boundary(const Case& c) {
  const auto* function = find_test_function(c.function).value();
  const double least = function->cost(Point(static_cast<std::size_t>(c.dimension), -1.0));
  Case named = c;
  named.function += " with the optimum in a corner";
  return measure(named, box(c.dimension, -4, 0), [=](Point x) {
    for (auto& v : x) v -= 1;
    return function->cost(x) - least;
  });
}

#ifdef PRIMO_WITH_PAGMO
Json on_pagmo(const Case& c) {
  const auto* function = find_test_function(c.function).value();
  return summary(c, [&](std::uint64_t seed, bool& hit) {
    return primo::bench::pagmo_evaluations(function->cost, function->lower, function->upper, c.dimension, c.target,
                                           c.budget, 0.25 * (function->upper - function->lower),
                                           static_cast<unsigned>(seed), hit);
  });
}
#endif

}  // namespace

int main(int argc, char** argv) {
  CLI::App app{"Evaluations that optimizers need on standard functions"};
  std::vector<int> dimensions = {10, 20, 40};
  std::vector<std::string> functions = {"sphere", "ellipsoid", "rosenbrock"};
  bool peers = false, alone = false, corners = true;
  app.add_option("--dim", dimensions, "dimensions")->capture_default_str();
  app.add_option("--function", functions, "test functions")->capture_default_str();
  app.add_flag("--alone", alone, "without pagmo, where it is installed");
  app.add_flag("--corners,!--no-corners", corners, "with the optimum in a corner of the box, too");
  app.add_flag("--all", peers, "the other optimizers too, on the sphere and on Rastrigin's function");
  CLI11_PARSE(app, argc, argv);

  Json results = Json::array();
  for (const int d : dimensions) {
    const int budget = 10000 * d;
    for (const auto& function : functions) {
      results.push_back(on_function({"cma", function, d, 1e-8, budget}));
#ifdef PRIMO_WITH_PAGMO
      if (!alone) results.push_back(on_pagmo({"pagmo cmaes", function, d, 1e-8, budget}));
#endif
    }
    for (const char* function : {"sphere", "ellipsoid"}) {
      if (corners) results.push_back(on_boundary({"cma", function, d, 1e-6, budget}));
    }
  }
  if (peers) {
    for (const auto& name : optimizer_names()) {
      results.push_back(on_function({name, "sphere", 4, 1, 20000}));
      results.push_back(on_function({name, "sphere", 10, 1e-8, 100000}));
      results.push_back(on_function({name, "rastrigin", 5, 1e-8, 100000}));
    }
  }
  std::printf("%s\n", Json{{"bench", "optimizer"}, {"results", results}}.dump(1).c_str());
}
