#include "optim/restarts.h"

#include <algorithm>
#include <cmath>

#include "core/random.h"

namespace primo::optim {
namespace {
constexpr int kMostDoublings = 14;  // λ0 2^14 candidates no budget holds
}

Restarts::Restarts(const OptimizerSettings& settings, int population)
    : rule_(settings.on_stagnation),
      seed_(Random(settings.seed, "cma small descents", {static_cast<std::uint64_t>(settings.restart)}).bits()),
      first_population_(population),
      first_sigma_(settings.sigma),
      plan_{population, settings.sigma} {}

bool Restarts::next(int spent) {
  if (rule_ == "stop") return false;
  ++count_;
  if (rule_ == "again") return true;
  (small_ ? spent_small_ : spent_large_) += spent;
  if (!small_) last_large_ = spent;
  small_ = rule_ == "bipop" && doublings_ > 0 && spent_small_ < spent_large_;
  if (small_) {
    plan_ = small_plan();
  } else {
    doublings_ = std::min(doublings_ + 1, kMostDoublings);
    plan_ = {first_population_ << doublings_, first_sigma_};
  }
  return true;
}

/// λ = ⌊λ0 (λ_large / 2 λ0)^(U²)⌋ and σ = σ0 10^(−2U'), for at most half the cost of the last large descent.
DescentPlan Restarts::small_plan() const {
  Random random(seed_, "small descent", {static_cast<std::uint64_t>(count_)});
  const double u = random.uniform();
  const double ratio = 0.5 * std::pow(2.0, doublings_);
  const int population = std::max(2, static_cast<int>(first_population_ * std::pow(ratio, u * u)));
  return {population, first_sigma_ * std::pow(10.0, -2 * random.uniform()), std::max(population, last_large_ / 2)};
}

void Restarts::save(State& state) const {
  state["restarts"] = {
      static_cast<double>(count_),       static_cast<double>(doublings_),   small_ ? 1.0 : 0.0,
      static_cast<double>(spent_large_), static_cast<double>(spent_small_), static_cast<double>(last_large_)};
  state["descent_plan"] = {static_cast<double>(plan_.population), plan_.sigma, static_cast<double>(plan_.limit)};
}

Status Restarts::load(const StateReader& state) {
  PRIMO_ASSIGN(const auto counts, state.numbers("restarts", 6));
  PRIMO_ASSIGN(const auto plan, state.numbers("descent_plan", 3));
  const auto whole = [](double v, double least, double most) { return v == std::floor(v) && v >= least && v <= most; };
  constexpr double kMost = std::numeric_limits<int>::max();
  const bool good = std::all_of(counts.begin(), counts.end(), [&](double v) { return whole(v, 0, kMost / 2); }) &&
                    counts[1] <= kMostDoublings && counts[2] <= 1 &&
                    whole(plan[0], 2, static_cast<double>(first_population_ << kMostDoublings)) && plan[1] > 0 &&
                    plan[1] <= first_sigma_ && whole(plan[2], 1, kMost);
  if (!good) return Error{Code::data, "the optimizer's state: 'restarts' or 'descent_plan' cannot be"};
  count_ = static_cast<int>(counts[0]);
  doublings_ = static_cast<int>(counts[1]);
  small_ = counts[2] == 1;
  spent_large_ = static_cast<int>(counts[3]);
  spent_small_ = static_cast<int>(counts[4]);
  last_large_ = static_cast<int>(counts[5]);
  plan_ = {static_cast<int>(plan[0]), plan[1], static_cast<int>(plan[2])};
  return success();
}

}  // namespace primo::optim
