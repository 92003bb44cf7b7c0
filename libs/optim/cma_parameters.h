// The strategy parameters of CMA-ES with active covariance update: Hansen, The CMA Evolution Strategy: A Tutorial,
// arXiv 1604.00772, table 1 and equations 49 to 58.
#pragma once

#include <Eigen/Core>

namespace primo::optim {

struct CmaParameters {
  CmaParameters(int dimension, int population);

  int n, lambda, mu;
  Eigen::VectorXd weights;  ///< λ of them, best rank first; the first μ sum to 1, the others are negative
  double mu_eff;            ///< variance effective selection mass of the positive weights
  double c_c, c_1, c_mu;    ///< rates of the covariance matrix
  double c_sigma, d_sigma;  ///< rate and damping of the step size
  double chi_n;             ///< E‖N(0, I)‖
  int decompose_every;      ///< generations between eigendecompositions
};

}  // namespace primo::optim
