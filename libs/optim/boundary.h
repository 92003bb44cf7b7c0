// The adaptive penalty of solutions outside a box whose evaluation was that of the nearest solution inside: Hansen,
// Niederberger, Guzzella and Koumoutsakos, A Method for Handling Uncertainty in Evolutionary Optimization, IEEE TEC 13
// (2009), section IV-B; weights above what a new one would begin with decay (decision 0510). Coordinates are those of
// the unit box, costs are minimised.
#pragma once

#include <Eigen/Core>
#include <deque>
#include <vector>

#include "optim/state.h"

namespace primo::optim {

/// The nearest point of the unit box.
inline Eigen::VectorXd repaired(const Eigen::VectorXd& u) { return u.cwiseMax(0.0).cwiseMin(1.0); }

class BoundaryPenalty {
 public:
  explicit BoundaryPenalty(int dimension) : weights_(Eigen::VectorXd::Zero(dimension)) {}

  /// Adapts the weights to the distribution N(mean, σ²C) and to the spread of this generation's costs of repaired
  /// solutions.
  void adapt(const std::vector<double>& costs, const Eigen::VectorXd& mean, double sigma,
             const Eigen::VectorXd& c_diagonal, double mu_eff);

  /// What is added to the cost of `u`; 0 inside the box, never negative, finite.
  double operator()(const Eigen::VectorXd& u, const Eigen::VectorXd& c_diagonal) const;

  void save(State& state) const;
  Status load(const StateReader& state, int dimension);

 private:
  Eigen::VectorXd weights_;
  bool active_ = false;
  std::deque<double> spreads_;  // interquartile ranges of the last generations
};

}  // namespace primo::optim
