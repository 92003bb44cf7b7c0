// One descent of CMA-ES: the distribution N(mean, σ²C) with its evolution paths, in the unit box; costs are minimised.
// Hansen, The CMA Evolution Strategy: A Tutorial, arXiv 1604.00772; the numbers in comments are its equations.
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <deque>
#include <vector>

#include "optim/boundary.h"
#include "optim/cma_parameters.h"
#include "optim/state.h"

namespace primo::optim {

struct Descent {
  Descent(int n, int lambda, Eigen::VectorXd start, double step);

  CmaParameters p;
  Eigen::VectorXd mean;
  double sigma;
  Eigen::MatrixXd C, B;  ///< C = B diag(D²) Bᵀ as of the last decomposition
  Eigen::VectorXd D, path_c, path_sigma;
  BoundaryPenalty penalty;
  int generations = 0;
  int updates = 0;  ///< generations that were not flat
  bool degenerate = false;
  std::deque<double> best_costs, median_costs;  ///< of the generations, as far back as stagnated() looks
  std::deque<double> mean_costs;                ///< of the last generations

  /// The point of the standard normal sample z; it may lie outside the box.
  Eigen::VectorXd point(const Eigen::VectorXd& z) const { return mean + sigma * (B * D.cwiseProduct(z)); }
  /// Learns from the costs of the λ points of z, each evaluated at the nearest point of the box. Candidates of equal
  /// cost share the weights of their ranks.
  void update(const std::vector<Eigen::VectorXd>& z, const std::vector<double>& costs);
  /// A generation of equal costs selects nothing; the distribution only gets wider, up to the step size `widest`.
  void pass_flat(const std::vector<double>& costs, double widest);
  bool stagnated() const;
  /// Mean fitness over the last generations: what the distribution was worth where it ended.
  double merit() const;
  double condition() const;  ///< of C

  void save(State& state) const;
  Status load(const StateReader& state);

 private:
  Eigen::VectorXd shared_weights(const std::vector<double>& costs, bool positive_only) const;
  void record(const std::vector<double>& costs);
  std::size_t window() const;
  bool at_the_bottom() const;
  void decompose();
};

}  // namespace primo::optim
