// What optimizers share whose candidates do not depend on the answers: the n-th is the same whatever the size of a
// generation, and the state is that of Generational alone.
#pragma once

#include <algorithm>
#include <utility>
#include <vector>

#include "optim/algorithms.h"
#include "optim/generational.h"

namespace primo::optim {

class Sampling : public Generational {
 public:
  bool keeps_only_best() const final { return true; }

 protected:
  Sampling(const OptimizerSettings& settings, const Bounds& bounds)
      : Generational(settings, bounds),
        population_(settings.population > 0 ? settings.population : default_population(bounds.lower.size())) {}

  /// The candidate of this number, counted from 0 over all generations, in the box.
  virtual std::vector<double> sample(int number) const = 0;

 private:
  std::vector<std::vector<double>> samples() const final {
    std::vector<std::vector<double>> points;
    points.reserve(static_cast<std::size_t>(size()));
    for (int k = 0; k < size(); ++k) points.push_back(sample(before() + k));
    return points;
  }
  void advance(const std::vector<double>&) final {}
  int wanted() const final { return std::clamp(settings().evaluations - evaluations(), 0, population_); }
  void save(State&) const final {}
  Status load(const StateReader&) final { return success(); }

  int population_;
};

}  // namespace primo::optim
