#include "rules/parameters.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

namespace primo::rules {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr double kGapPerExample = 1e-9;
constexpr int kMaxIterations = 2000;

/// Rows are cells, columns outcomes and then noise: the probability each gives to the cell's states.
struct Mixture {
  MatrixXd A;
  VectorXd weights;

  double log_likelihood(const VectorXd& p) const {
    const VectorXd likelihood = A * p;
    double sum = 0;
    for (Eigen::Index c = 0; c < weights.size(); ++c) {
      if (!(likelihood[c] > 0)) return -INFINITY;
      sum += weights[c] * std::log(likelihood[c]);
    }
    return sum;
  }
  VectorXd gradient(const VectorXd& p) const { return A.transpose() * weights.cwiseQuotient(A * p); }
};

Mixture make_mixture(const std::vector<MixtureCell>& cells, int outcomes, double p_min) {
  Mixture mixture{MatrixXd::Zero(static_cast<Eigen::Index>(cells.size()), outcomes + 1),
                  VectorXd(static_cast<Eigen::Index>(cells.size()))};
  for (Eigen::Index c = 0; c < mixture.weights.size(); ++c) {
    const auto& cell = cells[static_cast<std::size_t>(c)];
    mixture.weights[c] = cell.weight;
    mixture.A(c, outcomes) = p_min;
    for (const int i : cell.outcomes) mixture.A(c, i) = 1;
  }
  return mixture;
}

/// Cells of at most one outcome each: the KKT conditions in closed form. With m_i examples of outcome i, m_0 of none
/// and N in all, p_0 = m_0 / (N (1 − k p_min)) and p_i = m_i/N − p_min p_0, over the k outcomes for which that is
/// positive.
VectorXd closed_form(const std::vector<MixtureCell>& cells, int outcomes, double p_min) {
  VectorXd m = VectorXd::Zero(outcomes + 1);
  for (const auto& cell : cells) m[cell.outcomes.empty() ? outcomes : cell.outcomes.front()] += cell.weight;
  const double total = m.sum();
  std::vector<int> active;
  for (int i = 0; i < outcomes; ++i) {
    if (m[i] > 0) active.push_back(i);
  }
  VectorXd p = VectorXd::Zero(outcomes + 1);
  for (;;) {
    double unexplained = total;
    for (const int i : active) unexplained -= m[i];
    p.setZero();
    p[outcomes] = active.empty() ? 1 : unexplained / (total * (1 - static_cast<double>(active.size()) * p_min));
    for (const int i : active) p[i] = m[i] / total - p_min * p[outcomes];
    const auto negative = std::find_if(active.begin(), active.end(), [&](int i) { return !(p[i] > 0); });
    if (negative == active.end()) return p;
    active.erase(negative);
  }
}

/// A Newton step of the log-likelihood within the simplex, shortened until it stays inside and climbs; `p` itself if
/// none does.
VectorXd newton_step(const Mixture& mixture, const VectorXd& p, double value) {
  const Eigen::Index k = p.size();
  const VectorXd likelihood = mixture.A * p;
  const MatrixXd scaled = mixture.weights.cwiseSqrt().cwiseQuotient(likelihood).asDiagonal() * mixture.A;
  // In the variables d_i = p_i e_i the barrier-free system is well scaled also near the simplex's faces.
  const MatrixXd hessian = p.asDiagonal() * (scaled.transpose() * scaled) * p.asDiagonal();
  MatrixXd system = MatrixXd::Zero(k + 1, k + 1);
  system.topLeftCorner(k, k) = hessian;
  system.topLeftCorner(k, k).diagonal().array() += 1e-12 * std::max(hessian.trace(), 1e-300);
  system.topRightCorner(k, 1) = p;
  system.bottomLeftCorner(1, k) = p.transpose();
  VectorXd right = VectorXd::Zero(k + 1);
  right.head(k) = p.cwiseProduct(mixture.gradient(p));
  const VectorXd direction = p.cwiseProduct(system.partialPivLu().solve(right).head(k));
  if (!direction.allFinite()) return p;
  double step = 1;
  for (Eigen::Index i = 0; i < k; ++i) {
    if (direction[i] < 0) step = std::min(step, -0.99 * p[i] / direction[i]);
  }
  for (int halving = 0; halving < 30; ++halving, step /= 2) {
    VectorXd next = (p + step * direction).cwiseMax(0.0);
    next /= next.sum();
    if (mixture.log_likelihood(next) > value) return next;
  }
  return p;
}

VectorXd expectation_maximisation(const Mixture& mixture, int& iterations) {
  const double total = mixture.weights.sum();
  VectorXd p = VectorXd::Constant(mixture.A.cols(), 1.0 / static_cast<double>(mixture.A.cols()));
  for (iterations = 0; iterations < kMaxIterations; ++iterations) {
    const VectorXd gradient = mixture.gradient(p);
    if (gradient.maxCoeff() - total <= kGapPerExample * total) break;
    p = p.cwiseProduct(gradient) / total;  // the EM step; monotone, stays on the simplex
    p /= p.sum();
    p = newton_step(mixture, p, mixture.log_likelihood(p));
  }
  return p;
}

}  // namespace

MixtureFit fit_outcomes(const std::vector<MixtureCell>& cells, int outcomes, double p_min) {
  MixtureFit fit{.p = std::vector<double>(static_cast<std::size_t>(outcomes), 0.0)};
  if (cells.empty()) return fit;
  const Mixture mixture = make_mixture(cells, outcomes, p_min);
  const bool overlap =
      std::any_of(cells.begin(), cells.end(), [](const MixtureCell& cell) { return cell.outcomes.size() > 1; });
  VectorXd p = overlap ? expectation_maximisation(mixture, fit.iterations) : closed_form(cells, outcomes, p_min);
  // What is left of vanishing outcomes goes; the certificate is taken afterwards.
  constexpr double kVanished = 1e-7;
  VectorXd trimmed = (p.array() < kVanished).select(0.0, p);
  trimmed /= trimmed.sum();
  if (mixture.log_likelihood(trimmed) >= mixture.log_likelihood(p) - kGapPerExample * mixture.weights.sum())
    p = trimmed;
  fit.log_likelihood = mixture.log_likelihood(p);
  fit.gap = std::max(0.0, mixture.gradient(p).maxCoeff() - mixture.weights.sum());
  for (int i = 0; i < outcomes; ++i) fit.p[static_cast<std::size_t>(i)] = p[i];
  fit.noise = p[outcomes];
  return fit;
}

}  // namespace primo::rules
