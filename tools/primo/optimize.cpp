// primo optimize: an optimizer on one of the standard test functions, in this process.
#include <cmath>
#include <iostream>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>

#include "optim/checkpoint.h"
#include "optim/test_functions.h"
#include "primo/interrupt.h"
#include "primo/verbs.h"

namespace primo::tool {
namespace {

struct Options {
  std::string problem, checkpoint;
  int dimension = 10;
  std::optional<double> target, lower, upper;
  optim::OptimizerSettings optimizer{.evaluations = 100000, .sigma = 0.25};
  bool json = false;
};

/// What was found, and why the search ended: target, budget, stagnation or interrupted.
struct Found {
  std::unique_ptr<optim::Optimizer> optimizer;
  int evaluations = 0;
  double best = INFINITY;
  std::vector<double> x;
  std::string stop;

  void consider(double cost, const std::vector<double>& point) {
    if (!x.empty() && !(cost < best)) return;
    best = cost;
    x = point;
  }
};

Result<Found> search(const Options& options) {
  PRIMO_ASSIGN(const auto* function, optim::find_test_function(options.problem));
  const auto d = static_cast<std::size_t>(options.dimension);
  const optim::Bounds bounds{std::vector<double>(d, options.lower.value_or(function->lower)),
                             std::vector<double>(d, options.upper.value_or(function->upper))};
  Found found;
  PRIMO_ASSIGN(found.optimizer,
               options.checkpoint.empty()
                   ? optim::make_optimizer(options.optimizer, bounds)
                   : optim::load_checkpoint(options.checkpoint, options.optimizer, bounds, options.problem));
  auto& optimizer = *found.optimizer;
  if (std::isfinite(optimizer.best_fitness())) found.consider(-optimizer.best_fitness(), optimizer.best());
  const auto reached = [&] { return options.target && found.best <= *options.target; };

  while (!reached() && !optimizer.done() && !interrupted()) {
    for (const auto& candidate : optimizer.ask()) {
      const double cost = function->cost(candidate.x);
      PRIMO_TRY(optimizer.tell(candidate.generation, candidate.index, -cost));
      found.consider(cost, candidate.x);
      if (reached()) break;
    }
    if (!options.checkpoint.empty()) {
      PRIMO_TRY(optim::save_checkpoint(options.checkpoint, optimizer, options.problem));
    }
  }
  found.evaluations = optimizer.evaluations();
  found.stop = reached()               ? "target"
               : !optimizer.done()     ? "interrupted"
               : optimizer.stagnated() ? "stagnation"
                                       : "budget";
  return found;
}

Status optimize(const Options& options, int& exit) {
  catch_interrupts();
  PRIMO_ASSIGN(const Found found, search(options));
  if (found.stop == "interrupted") exit = kInterrupted;
  if (options.json) {
    const nlohmann::ordered_json out = {{"problem", options.problem},
                                        {"dimension", options.dimension},
                                        {"optimizer", options.optimizer.name},
                                        {"seed", options.optimizer.seed},
                                        {"evaluations", found.evaluations},
                                        {"best", found.best},
                                        {"x", found.x},
                                        {"restarts", found.optimizer->restarts()},
                                        {"stop", found.stop}};
    std::cout << out.dump() << "\n";
    return success();
  }
  std::cout << options.optimizer.name << " on " << options.problem << " in " << options.dimension
            << " dimensions: " << found.best << " after " << found.evaluations << " evaluations, "
            << found.optimizer->restarts() << " restarts; ended by " << found.stop << "\nx:";
  for (const double value : found.x) std::cout << " " << value;
  std::cout << "\n";
  return success();
}

}  // namespace

void add_optimize(CLI::App& app, int& exit) {
  auto* verb = app.add_subcommand("optimize", "minimises a standard test function");
  const auto options = std::make_shared<Options>();
  auto& settings = options->optimizer;
  std::string problems;
  for (const auto& function : optim::test_functions())
    problems += std::string(problems.empty() ? "" : ", ") + function.name;
  verb->add_option("--problem", options->problem, problems)->required();
  verb->add_option("--dim", options->dimension, "dimensions")->check(CLI::Range(1, 1000))->capture_default_str();
  verb->add_option("--optimizer", settings.name, config::detail::joined(optim::optimizer_names()))
      ->capture_default_str();
  verb->add_option("--seed", settings.seed, "of all random numbers")->capture_default_str();
  verb->add_option("--target", options->target, "ends when this cost is reached");
  verb->add_option("--max-evaluations", settings.evaluations, "budget")
      ->check(CLI::Range(1, 1000000000))
      ->capture_default_str();
  verb->add_option("--population", settings.population, "candidates a generation; 0: the algorithm's default")
      ->check(CLI::Range(0, 10000))
      ->capture_default_str();
  verb->add_option("--sigma", settings.sigma, "initial step, fraction of the box's width")->capture_default_str();
  verb->add_option("--on-stagnation", settings.on_stagnation, "ipop, bipop, again or stop (cma)")
      ->capture_default_str();
  verb->add_option("--patience", settings.patience,
                   "generations without a rise after which a descent has stagnated; 0: no such limit (cma)")
      ->check(CLI::Range(0, 1000000))
      ->capture_default_str();
  verb->add_option("--lower", options->lower, "bound of every coordinate; default: the problem's own");
  verb->add_option("--upper", options->upper, "bound of every coordinate; default: the problem's own");
  verb->add_option("--checkpoint", options->checkpoint,
                   "writes this file after each generation; goes on from it where it is there");
  verb->add_flag("--json", options->json, "print JSON");
  verb->callback([options, &exit] {
    if (const int code = report(optimize(*options, exit)); code != 0) exit = code;
  });
}

}  // namespace primo::tool
