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

void Patience::save(State& state) const { state["patience"] = {static_cast<double>(since_), best_, mean_}; }

Status Patience::load(const StateReader& state) {
  PRIMO_ASSIGN(const auto numbers, state.numbers("patience", 3));
  if (!(numbers[0] >= 0 && numbers[0] < 2e9 && numbers[0] == static_cast<double>(static_cast<int>(numbers[0])))) {
    return Error{Code::data, "the optimizer's state: 'patience' cannot be"};
  }
  since_ = static_cast<int>(numbers[0]);
  best_ = numbers[1];
  mean_ = numbers[2];
  return success();
}

}  // namespace primo::optim
