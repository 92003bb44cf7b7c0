// CMA-ES with active covariance update (descent.h). The box is scaled to the unit box. Solutions outside are evaluated
// at the nearest point inside and penalised (boundary.h). A descent that has stagnated is followed by another one
// (restarts.h).
#include <algorithm>
#include <cmath>
#include <limits>

#include "core/random.h"
#include "optim/algorithms.h"
#include "optim/descent.h"
#include "optim/generational.h"
#include "optim/patience.h"
#include "optim/restarts.h"

namespace primo::optim {
namespace {

using Eigen::VectorXd;

class Cma final : public Generational {
 public:
  Cma(const OptimizerSettings& settings, const Bounds& bounds)
      : Generational(settings, bounds),
        restarts_(settings, settings.population > 0 ? settings.population : default_population(bounds.lower.size())),
        descent_(start()),
        patience_(settings.patience, settings.least_rise) {
    begin();
  }

  std::vector<double> recommendation() const override {
    const bool present = kept_mean_.size() == 0 || (!descent_.mean_costs.empty() && descent_.merit() > kept_merit_);
    return in_box(flat(present ? descent_.mean : kept_mean_));
  }
  double sigma() const override { return descent_.sigma; }
  double condition() const override { return descent_.condition(); }
  int restarts() const override { return restarts_.count(); }
  bool stagnated() const override { return ended_; }

 private:
  Descent start() const {
    Random random(settings().seed, "cma start",
                  {static_cast<std::uint64_t>(settings().restart), static_cast<std::uint64_t>(starts_)});
    VectorXd mean(dimension());
    for (auto& coordinate : mean) coordinate = random.uniform();
    return Descent(dimension(), restarts_.plan().population, mean, restarts_.plan().sigma);
  }

  VectorXd normal(int index) const {
    Random random(settings().seed, "cma",
                  {static_cast<std::uint64_t>(settings().restart), static_cast<std::uint64_t>(number()),
                   static_cast<std::uint64_t>(index)});
    VectorXd z(dimension());
    for (auto& coordinate : z) coordinate = random.normal();
    return z;
  }

  /// Standard normal each, and at right angles to each other in blocks of d: the directions of independent draws made
  /// orthogonal, with the lengths that these draws had. So a generation looks into different directions (Wang, Emmerich
  /// and Baeck, Mirrored Orthogonal Sampling for Covariance Matrix Adaptation Evolution Strategies, Evolutionary
  /// Computation 27 (2019)).
  std::vector<VectorXd> draws() const {
    std::vector<VectorXd> all, directions;
    all.reserve(static_cast<std::size_t>(size()));
    for (int k = 0; k < size(); ++k) {
      if (k % dimension() == 0) directions.clear();
      const VectorXd raw = normal(k);
      VectorXd z = raw;
      for (int pass = 0; pass < 2; ++pass) {  // twice is enough for right angles to the last digits
        for (const auto& direction : directions) z -= direction.dot(z) * direction;
      }
      const double rest = z.norm();
      if (rest > 0) directions.push_back(z / rest);
      all.push_back(rest > 0 ? z * (raw.norm() / rest) : raw);
    }
    return all;
  }

  std::vector<std::vector<double>> samples() const override {
    std::vector<std::vector<double>> points;
    points.reserve(static_cast<std::size_t>(size()));
    for (const auto& z : draws()) points.push_back(in_box(flat(descent_.point(z))));
    return points;
  }

  void advance(const std::vector<double>& fitness) override {
    std::vector<double> costs;
    costs.reserve(fitness.size());
    for (const double value : fitness) costs.push_back(-value);
    const auto [low, high] = std::minmax_element(costs.begin(), costs.end());
    worst_ = std::max(worst_, *high);
    spent_ += size();
    patience_.add(costs);
    if (*low < *high) {
      descent_.update(draws(), costs);
    } else {
      // On the highest plateau found the distribution stays as it is.
      const bool on_top = -*low == best_fitness() && worst_ > *low;
      descent_.pass_flat(costs, on_top ? descent_.sigma : settings().sigma);
    }
    if (descent_.stagnated() || patience_.over() || spent_ >= restarts_.plan().limit) {
      keep_if_better();
      ended_ = !restarts_.next(spent_);
      if (!ended_) start_again();
    } else if (descent_.updates == 0) {
      keep_if_better();
      start_again();  // nothing to descend here: look elsewhere
    }
  }

  void start_again() {
    ++starts_;
    spent_ = 0;
    descent_ = start();
    patience_.reset();
  }

  int wanted() const override { return restarts_.plan().population; }
  std::string stopped() const override {
    return ended_ ? "the search has stagnated after " + std::to_string(evaluations()) + " evaluations" : "";
  }

  void keep_if_better() {
    if (kept_mean_.size() > 0 && !(descent_.merit() > kept_merit_)) return;
    kept_mean_ = descent_.mean;
    kept_merit_ = descent_.merit();
  }

  void save(State& state) const override {
    restarts_.save(state);
    descent_.save(state);
    patience_.save(state);
    state["cma"] = {static_cast<double>(starts_), static_cast<double>(spent_), ended_ ? 1.0 : 0.0};
    state["worst_cost"] = std::isfinite(worst_) ? std::vector<double>{worst_} : std::vector<double>{};
    state["kept_mean"] = flat(kept_mean_);
    state["kept_merit"] = {kept_merit_};
  }

  Status load(const StateReader& state) override {
    PRIMO_TRY(restarts_.load(state));
    descent_ = start();
    PRIMO_TRY(descent_.load(state));
    PRIMO_TRY(patience_.load(state));
    PRIMO_ASSIGN(const auto counts, state.numbers("cma", 3));
    PRIMO_ASSIGN(const auto worst, state.numbers("worst_cost"));
    PRIMO_ASSIGN(const auto kept, state.numbers("kept_mean"));
    PRIMO_ASSIGN(kept_merit_,
                 state.number("kept_merit", std::numeric_limits<double>::lowest(), std::numeric_limits<double>::max()));
    const auto count = [](double v) { return v >= 0 && v < 2e9 && v == std::floor(v); };
    if (!count(counts[0]) || !count(counts[1]) || worst.size() > 1 ||
        (!kept.empty() && kept.size() != static_cast<std::size_t>(dimension()))) {
      return Error{Code::data, "the optimizer's state: 'cma', 'worst_cost' or 'kept_mean' cannot be"};
    }
    starts_ = static_cast<int>(counts[0]);
    spent_ = static_cast<int>(counts[1]);
    ended_ = counts[2] != 0;
    worst_ = worst.empty() ? -std::numeric_limits<double>::infinity() : worst[0];
    kept_mean_ = Eigen::Map<const VectorXd>(kept.data(), static_cast<Eigen::Index>(kept.size()));
    return success();
  }

  int starts_ = 0;  // of descents, before the present one
  int spent_ = 0;   // evaluations of the present descent
  bool ended_ = false;
  Restarts restarts_;
  Descent descent_;
  Patience patience_;
  double worst_ = -std::numeric_limits<double>::infinity();  // cost
  VectorXd kept_mean_;                                       // of the best descent that ended; empty before the first
  double kept_merit_ = 0;
};

}  // namespace

std::unique_ptr<Optimizer> make_cma(const OptimizerSettings& settings, const Bounds& bounds) {
  return std::make_unique<Cma>(settings, bounds);
}

}  // namespace primo::optim
