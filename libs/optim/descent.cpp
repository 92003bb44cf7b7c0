#include "optim/descent.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <numeric>

namespace primo::optim {
namespace {

constexpr std::size_t kLongestWindow = 20000;  // generations
constexpr double kSmallestStep = 1e-12;        // of the unit box: below it all candidates are one point
constexpr double kLargestCondition = 1e14;     // of C: above it the eigendecomposition has lost its digits
constexpr double kSameCost = 1e-12;            // relative
constexpr std::size_t kMeritGenerations = 10;

double median(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

/// Whether costs have stopped falling: the median of the newest 30 % is not below that of the oldest 30 % of the
/// window.
bool stalled(const std::deque<double>& history, std::size_t window) {
  const auto part = static_cast<std::ptrdiff_t>(0.3 * static_cast<double>(window));
  const auto begin = history.end() - static_cast<std::ptrdiff_t>(window);
  return median({history.end() - part, history.end()}) >= median({begin, begin + part});
}

}  // namespace

using Eigen::MatrixXd;
using Eigen::VectorXd;

Descent::Descent(int n, int lambda, VectorXd start, double step)
    : p(n, lambda),
      mean(std::move(start)),
      sigma(step),
      C(MatrixXd::Identity(n, n)),
      B(MatrixXd::Identity(n, n)),
      D(VectorXd::Ones(n)),
      path_c(VectorXd::Zero(n)),
      path_sigma(VectorXd::Zero(n)),
      penalty(n) {}

/// The weight of each candidate; candidates of equal cost get the mean weight of their ranks.
VectorXd Descent::shared_weights(const std::vector<double>& costs, bool positive_only) const {
  const auto size = static_cast<std::size_t>(p.lambda);
  std::vector<std::size_t> order(size);
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) { return costs[a] < costs[b]; });
  VectorXd weights(p.lambda);
  for (std::size_t first = 0, last = 0; first < size; first = last) {
    double sum = 0;
    for (last = first; last < size && costs[order[last]] == costs[order[first]]; ++last) {
      const double weight = p.weights[static_cast<Eigen::Index>(last)];
      sum += positive_only ? std::max(0.0, weight) : weight;
    }
    for (std::size_t i = first; i < last; ++i) {
      weights[static_cast<Eigen::Index>(order[i])] = sum / static_cast<double>(last - first);
    }
  }
  return weights;
}

void Descent::update(const std::vector<VectorXd>& z, const std::vector<double>& costs) {
  penalty.adapt(costs, mean, sigma, C.diagonal(), p.mu_eff);
  std::vector<VectorXd> y;
  std::vector<double> penalised;
  for (std::size_t k = 0; k < z.size(); ++k) {
    y.push_back(B * D.cwiseProduct(z[k]));
    penalised.push_back(costs[k] + penalty(mean + sigma * y.back(), C.diagonal()));
  }
  const VectorXd selection = shared_weights(penalised, true);
  const VectorXd weights = shared_weights(penalised, false);
  // Shared weights select less sharply; with their own μ_eff the paths stay N(0, C) under random selection.
  const double mu_eff = 1 / selection.squaredNorm();

  VectorXd step = VectorXd::Zero(p.n);
  for (std::size_t k = 0; k < y.size(); ++k) step += selection[static_cast<Eigen::Index>(k)] * y[k];
  mean += sigma * step;  // (42)

  const VectorXd whitened = B * (B.transpose() * step).cwiseQuotient(D);
  path_sigma = (1 - p.c_sigma) * path_sigma + std::sqrt(p.c_sigma * (2 - p.c_sigma) * mu_eff) * whitened;  // (43)
  const double decay = 1 - std::pow(1 - p.c_sigma, 2.0 * (updates + 1));
  const bool heaviside = path_sigma.norm() / std::sqrt(decay) < (1.4 + 2 / (p.n + 1.0)) * p.chi_n;
  path_c = (1 - p.c_c) * path_c;  // (45)
  if (heaviside) path_c += std::sqrt(p.c_c * (2 - p.c_c) * mu_eff) * step;

  const double lost = heaviside ? 0 : p.c_1 * p.c_c * (2 - p.c_c);
  C *= 1 + lost - p.c_1 - p.c_mu * p.weights.sum();  // (47)
  C += p.c_1 * path_c * path_c.transpose();
  for (std::size_t k = 0; k < y.size(); ++k) {
    double weight = weights[static_cast<Eigen::Index>(k)];
    if (weight < 0) weight *= p.n / std::max(z[k].squaredNorm(), 1e-300);  // (46)
    C += p.c_mu * weight * y[k] * y[k].transpose();
  }
  sigma *= std::exp(std::min(1.0, p.c_sigma / p.d_sigma * (path_sigma.norm() / p.chi_n - 1)));  // (44)
  ++updates;
  record(costs);
  if (updates % p.decompose_every == 0) decompose();
}

void Descent::pass_flat(const std::vector<double>& costs, double widest) {
  sigma = std::max(sigma, std::min(widest, sigma * std::exp(0.2 + p.c_sigma / p.d_sigma)));
  record(costs);
}

void Descent::record(const std::vector<double>& costs) {
  best_costs.push_back(*std::min_element(costs.begin(), costs.end()));
  median_costs.push_back(median(costs));
  double average = 0;
  for (const double cost : costs) average += cost / static_cast<double>(costs.size());
  mean_costs.push_back(average);
  if (mean_costs.size() > kMeritGenerations) mean_costs.pop_front();
  ++generations;
  while (best_costs.size() > window()) {
    best_costs.pop_front();
    median_costs.pop_front();
  }
}

void Descent::decompose() {
  C = (0.5 * (C + C.transpose())).eval();
  if (!C.allFinite() || !mean.allFinite() || !std::isfinite(sigma)) {
    degenerate = true;
    return;
  }
  const Eigen::SelfAdjointEigenSolver<MatrixXd> solver(C);
  const double smallest = solver.eigenvalues().minCoeff(), largest = solver.eigenvalues().maxCoeff();
  if (solver.info() != Eigen::Success || !(smallest > 0) || largest > kLargestCondition * smallest) {
    degenerate = true;
    return;
  }
  B = solver.eigenvectors();
  D = solver.eigenvalues().cwiseSqrt();
  // Wider than the box there is nothing to find.
  sigma = std::min(sigma, 1 / std::sqrt(C.diagonal().maxCoeff()));
}

std::size_t Descent::window() const {
  const auto least = static_cast<std::size_t>(120 + 30.0 * p.n / p.lambda);
  return std::clamp<std::size_t>(static_cast<std::size_t>(generations) / 5, least, kLongestWindow);
}

/// Whether the costs of the last 10 + 30 n/λ generations differ, but by no more than their last digits: the bottom of a
/// hollow. Equal costs are a plateau, and no reason to leave.
bool Descent::at_the_bottom() const {
  const auto span = static_cast<std::ptrdiff_t>(10 + 30 * p.n / p.lambda);
  if (static_cast<std::ptrdiff_t>(best_costs.size()) < span) return false;
  const auto low = std::min_element(best_costs.end() - span, best_costs.end());
  const auto high = std::max_element(median_costs.end() - span, median_costs.end());
  return *high > *low && *high - *low <= kSameCost * std::max(std::abs(*low), std::abs(*high));
}

bool Descent::stagnated() const {
  if (degenerate || !(sigma * std::sqrt(C.diagonal().maxCoeff()) > kSmallestStep)) return true;
  if (at_the_bottom()) return true;
  return best_costs.size() >= window() && stalled(best_costs, window()) && stalled(median_costs, window());
}

double Descent::merit() const {
  double sum = 0;
  for (const double cost : mean_costs) sum -= cost / static_cast<double>(mean_costs.size());
  return sum;
}

double Descent::condition() const {
  const double ratio = D.maxCoeff() / D.minCoeff();
  return ratio * ratio;
}

void Descent::save(State& state) const {
  state["mean"] = flat(mean);
  state["sigma"] = {sigma};
  state["C"] = flat(C);
  state["B"] = flat(B);
  state["D"] = flat(D);
  state["path_c"] = flat(path_c);
  state["path_sigma"] = flat(path_sigma);
  state["descent"] = {static_cast<double>(generations), static_cast<double>(updates), degenerate ? 1.0 : 0.0};
  state["best_costs"] = {best_costs.begin(), best_costs.end()};
  state["median_costs"] = {median_costs.begin(), median_costs.end()};
  state["mean_costs"] = {mean_costs.begin(), mean_costs.end()};
  penalty.save(state);
}

Status Descent::load(const StateReader& state) {
  PRIMO_ASSIGN(mean, state.vector("mean", p.n));
  PRIMO_ASSIGN(sigma, state.number("sigma", 0, 1e300));
  PRIMO_ASSIGN(C, state.square("C", p.n));
  PRIMO_ASSIGN(B, state.square("B", p.n));
  PRIMO_ASSIGN(D, state.vector("D", p.n));
  PRIMO_ASSIGN(path_c, state.vector("path_c", p.n));
  PRIMO_ASSIGN(path_sigma, state.vector("path_sigma", p.n));
  PRIMO_ASSIGN(const auto counts, state.numbers("descent", 3));
  PRIMO_ASSIGN(const auto best, state.numbers("best_costs"));
  PRIMO_ASSIGN(const auto medians, state.numbers("median_costs", best.size()));
  PRIMO_ASSIGN(const auto means, state.numbers("mean_costs"));
  const bool good = (B * B.transpose()).isIdentity(1e-6) && C.isApprox(C.transpose(), 1e-9) &&
                    C.diagonal().minCoeff() > 0 && D.minCoeff() > 0 && counts[0] >= counts[1] && counts[1] >= 0 &&
                    counts[0] <= 2e9 && best.size() <= kLongestWindow && best.size() <= counts[0] &&
                    means.size() <= kMeritGenerations;
  if (!good) return Error{Code::data, "the optimizer's state: its distribution cannot be"};
  generations = static_cast<int>(counts[0]);
  updates = static_cast<int>(counts[1]);
  degenerate = counts[2] != 0;
  best_costs.assign(best.begin(), best.end());
  median_costs.assign(medians.begin(), medians.end());
  mean_costs.assign(means.begin(), means.end());
  return penalty.load(state, p.n);
}

}  // namespace primo::optim
