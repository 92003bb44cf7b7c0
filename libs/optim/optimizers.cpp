#include <algorithm>
#include <cmath>
#include <iterator>

#include "optim/algorithms.h"
#include "optim/optimizer.h"

namespace primo::optim {
namespace {

struct Entry {
  const char* name;
  std::unique_ptr<Optimizer> (*make)(const OptimizerSettings&, const Bounds&);
  int (*population)(std::size_t dimension);  // where the settings leave it open
  int least_population;
};

// The one table of optimizers.
constexpr Entry kOptimizers[] = {
    {"cma", make_cma, default_population, 2},
    {"monte_carlo", make_monte_carlo, default_population, 1},
    {"sobol", make_sobol, default_population, 1},
    {"differential_evolution", make_differential_evolution, default_evolution_population, 4},
};

Error config(std::string message) { return {Code::config, std::move(message)}; }

Status check(const Entry& entry, const OptimizerSettings& settings, const Bounds& bounds) {
  if (bounds.lower.empty() || bounds.lower.size() != bounds.upper.size()) {
    return config("bounds of " + std::to_string(bounds.lower.size()) + " and " + std::to_string(bounds.upper.size()) +
                  " coordinates; both must have the same number, at least 1");
  }
  for (std::size_t i = 0; i < bounds.lower.size(); ++i) {
    const double width = bounds.upper[i] - bounds.lower[i];
    if (!std::isfinite(width) || !(width > 0)) {
      return config("bounds of coordinate " + std::to_string(i) + " are [" + std::to_string(bounds.lower[i]) + ", " +
                    std::to_string(bounds.upper[i]) + "]; they must be finite, the lower below the upper");
    }
  }
  if (!std::isfinite(settings.sigma) || !(settings.sigma > 0)) {
    return config("sigma is " + std::to_string(settings.sigma) + "; it must be above 0");
  }
  if (settings.population != 0 && settings.population < entry.least_population) {
    return config("population is " + std::to_string(settings.population) + "; for " + entry.name +
                  " it must be 0 (default) or at least " + std::to_string(entry.least_population));
  }
  constexpr const char* kRules[] = {"ipop", "bipop", "again", "stop"};
  if (std::find(std::begin(kRules), std::end(kRules), settings.on_stagnation) == std::end(kRules)) {
    return config("on_stagnation is \"" + settings.on_stagnation + "\"; it must be ipop, bipop, again or stop");
  }
  if (settings.patience < 0 || !(settings.least_rise >= 0))
    return config("patience and least_rise must not be negative");
  if (settings.restart < 0)
    return config("restart is " + std::to_string(settings.restart) + "; it must not be negative");
  const int population = settings.population > 0 ? settings.population : entry.population(bounds.lower.size());
  if (settings.evaluations < population) {
    return config("a budget of " + std::to_string(settings.evaluations) + " evaluations is below one generation of " +
                  std::to_string(population));
  }
  return success();
}

}  // namespace

int default_population(std::size_t dimension) {
  return 4 + static_cast<int>(std::floor(3.0 * std::log(static_cast<double>(dimension))));
}

Result<std::unique_ptr<Optimizer>> make_optimizer(const OptimizerSettings& settings, const Bounds& bounds) {
  for (const auto& entry : kOptimizers) {
    if (settings.name != entry.name) continue;
    PRIMO_TRY(check(entry, settings, bounds));
    return entry.make(settings, bounds);
  }
  std::string known;
  for (const auto& name : optimizer_names()) known += (known.empty() ? "" : ", ") + name;
  return config("no optimizer is named \"" + settings.name + "\"; known: " + known);
}

std::vector<std::string> optimizer_names() {
  std::vector<std::string> names;
  for (const auto& entry : kOptimizers) names.emplace_back(entry.name);
  return names;
}

}  // namespace primo::optim
