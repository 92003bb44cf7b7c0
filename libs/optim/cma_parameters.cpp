#include "optim/cma_parameters.h"

#include <algorithm>
#include <cmath>

namespace primo::optim {

CmaParameters::CmaParameters(int dimension, int population)
    : n(dimension), lambda(population), mu(population / 2), weights(population) {
  const double d = n;
  for (int i = 0; i < lambda; ++i) weights[i] = std::log((lambda + 1) / 2.0) - std::log(i + 1.0);
  const auto positive = weights.head(mu);
  const auto negative = weights.tail(lambda - mu);
  mu_eff = positive.sum() * positive.sum() / positive.squaredNorm();
  const double negative_norm2 = negative.squaredNorm();
  const double mu_eff_negative = negative_norm2 > 0 ? negative.sum() * negative.sum() / negative_norm2 : 0;

  c_sigma = (mu_eff + 2) / (d + mu_eff + 5);
  d_sigma = 1 + 2 * std::max(0.0, std::sqrt((mu_eff - 1) / (d + 1)) - 1) + c_sigma;
  c_c = (4 + mu_eff / d) / (d + 4 + 2 * mu_eff / d);
  c_1 = 2 / ((d + 1.3) * (d + 1.3) + mu_eff);
  c_mu = std::min(1 - c_1, 2 * (0.25 + mu_eff + 1 / mu_eff - 2) / ((d + 2) * (d + 2) + mu_eff));
  chi_n = std::sqrt(d) * (1 - 1 / (4 * d) + 1 / (21 * d * d));

  // The negative weights are as large as keeps C positive definite.
  double scale = 1 + 2 * mu_eff_negative / (mu_eff + 2);
  if (c_mu > 0) {
    scale = std::min({1 + c_1 / c_mu, scale, (1 - c_1 - c_mu) / (d * c_mu)});
  }
  const double negative_sum = -negative.sum();
  weights.head(mu) /= positive.sum();
  if (negative_sum > 0) weights.tail(lambda - mu) *= std::max(0.0, scale) / negative_sum;
  decompose_every = std::max(1, static_cast<int>(1 / (10 * d * (c_1 + c_mu))));
}

}  // namespace primo::optim
