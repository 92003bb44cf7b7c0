#include "optim/patience.h"

#include <algorithm>
#include <numeric>

namespace primo::optim {

void Patience::add(const std::vector<double>& costs) {
  const double best = *std::min_element(costs.begin(), costs.end());
  const double mean = std::accumulate(costs.begin(), costs.end(), 0.0) / static_cast<double>(costs.size());
  ++since_;
  if (best < best_ - rise_) {
    best_ = best;
    since_ = 0;
  }
  if (mean < mean_ - rise_) {
    mean_ = mean;
    since_ = 0;
  }
}

void Patience::save(State& state) const {
  state["patience"] = {static_cast<double>(since_)};
  state["patience_costs"] = {best_, mean_};
}

Status Patience::load(const StateReader& state) {
  PRIMO_ASSIGN(since_, state.whole("patience", 0, 2'000'000'000));
  PRIMO_ASSIGN(const auto costs, state.numbers("patience_costs", 2));
  best_ = costs[0];
  mean_ = costs[1];
  return success();
}

}  // namespace primo::optim
