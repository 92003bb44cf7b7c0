// What CMA-ES does after a stagnated descent (the setting on_stagnation):
//   ipop   begin elsewhere with twice the population (Auger and Hansen, A Restart CMA Evolution Strategy With
//   Increasing
//          Population Size, CEC 2005)
//   bipop  the same, and between these many small populations with small steps, as long as they have cost less (Hansen,
//          Benchmarking a BI-Population CMA-ES on the BBOB-2009 Function Testbed, GECCO 2009)
//   again  begin elsewhere with the same population
//   stop   end
#pragma once

#include <limits>

#include "optim/optimizer.h"
#include "optim/state.h"

namespace primo::optim {

/// How a descent begins, and after how many evaluations it ends at the latest.
struct DescentPlan {
  int population = 0;
  double sigma = 0;
  int limit = std::numeric_limits<int>::max();
};

class Restarts {
 public:
  /// `population` and `sigma` are those of the first descent.
  Restarts(const OptimizerSettings& settings, int population);

  const DescentPlan& plan() const { return plan_; }  ///< of the present descent
  int count() const { return count_; }
  /// The present descent ended after `spent` evaluations. False when there is to be no other.
  bool next(int spent);

  void save(State& state) const;
  Status load(const StateReader& state);

 private:
  DescentPlan small_plan() const;
  std::string rule_;
  std::uint64_t seed_;
  int first_population_;
  double first_sigma_;
  DescentPlan plan_;
  int count_ = 0, doublings_ = 0;
  bool small_ = false;
  int spent_large_ = 0, spent_small_ = 0, last_large_ = 0;  // evaluations: in all, in all, of the last large descent
};

}  // namespace primo::optim
