// The bookkeeping that ask/tell optimizers share: which members of the present generation have been told what.
#pragma once

#include <algorithm>
#include <cmath>
#include <optional>
#include <string>
#include <vector>

#include "core/result.h"

namespace primo::optim {

class Generation {
 public:
  explicit Generation(int size) : fitness_(static_cast<std::size_t>(size)) {}

  int number() const { return number_; }
  int size() const { return static_cast<int>(fitness_.size()); }
  bool complete() const { return told_ == size(); }
  double fitness(int index) const { return fitness_[static_cast<std::size_t>(index)].value(); }

  /// True when the result is new; false when it is late or doubled.
  Result<bool> tell(int generation, int index, double fitness) {
    if (index < 0 || (generation == number_ && index >= size())) {
      return Error{Code::data, "candidate " + std::to_string(index) + " of generation " + std::to_string(generation) +
                                   " does not exist; the indices are 0 to " + std::to_string(size() - 1)};
    }
    if (!std::isfinite(fitness)) {
      return Error{Code::data, "the fitness of candidate " + std::to_string(index) + " of generation " +
                                   std::to_string(generation) + " is not finite"};
    }
    if (generation > number_ || generation < 0) {
      return Error{Code::data, "generation " + std::to_string(generation) + " has not been asked; the present one is " +
                                   std::to_string(number_)};
    }
    if (generation < number_) return false;
    auto& slot = fitness_[static_cast<std::size_t>(index)];
    if (slot.has_value()) return false;
    slot = fitness;
    ++told_;
    return true;
  }

  void next(int size) {
    ++number_;
    told_ = 0;
    fitness_.assign(static_cast<std::size_t>(size), std::nullopt);
  }

 private:
  int number_ = 0;
  int told_ = 0;
  std::vector<std::optional<double>> fitness_;
};

/// The best sample so far; the first one among equals.
struct Best {
  std::vector<double> x;
  double fitness = -INFINITY;
  void consider(const std::vector<double>& candidate, double value) {
    if (!x.empty() && !(value > fitness)) return;
    x = candidate;
    fitness = value;
  }
};

}  // namespace primo::optim
