// The probabilities of a rule's outcomes: exact maximum likelihood, also when several outcomes explain one example.
#pragma once

#include <vector>

namespace primo::rules {

/// Examples that are explained by exactly these outcomes (indices, ascending); none: only noise explains them.
struct MixtureCell {
  std::vector<int> outcomes;
  double weight = 0;  ///< number of examples
};

struct MixtureFit {
  std::vector<double> p;  ///< of each outcome
  double noise = 1;       ///< p_0
  double log_likelihood = 0;
  /// Certificate: the log-likelihood is within this of the maximum (nats). With the gradient g of the concave
  /// log-likelihood on the simplex, L* − L ≤ max_i g_i − g·p.
  double gap = 0;
  int iterations = 0;
};

/// Maximises L(p) = Σ weight · log(p_min p_0 + Σ_{i explains} p_i) over the simplex; 0 < p_min < 1. Without examples:
/// all noise. Where no example has two explanations this is the closed form; else expectation maximisation with Newton
/// steps, until the gap is at most 1e-9 nats an example.
MixtureFit fit_outcomes(const std::vector<MixtureCell>& cells, int outcomes, double p_min);

}  // namespace primo::rules
