// CMA-ES with active covariance update (Hansen, The CMA Evolution Strategy: A Tutorial, arXiv 1604.00772; the numbers
// in comments are its equations). The box is scaled to the unit box. Solutions outside are evaluated at the nearest
// point inside and penalised.
//
// Candidates of equal cost share the weights of their ranks, so that a fitness of few values (a success rate) gives an
// update that does not depend on the candidates' order. After stagnation the search starts again at another random
// point with twice the population (Auger and Hansen, A Restart CMA Evolution Strategy With Increasing Population Size,
// CEC 2005).
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <deque>
#include <numeric>

#include "core/random.h"
#include "optim/algorithms.h"
#include "optim/boundary.h"
#include "optim/cma_parameters.h"
#include "optim/generation.h"

namespace primo::optim {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr double kSmallestStep = 1e-12;     // of the unit box: below it all candidates are one point
constexpr double kLargestCondition = 1e14;  // of C: above it the eigendecomposition has lost its digits
constexpr std::size_t kMeritGenerations = 10;

double median(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

/// Whether costs have stopped falling: the median of the newest 30 % is not below that of the oldest 30 % of the
/// window.
bool stalled(const std::vector<double>& history, std::size_t window) {
  const auto part = static_cast<std::ptrdiff_t>(0.3 * static_cast<double>(window));
  const auto begin = history.end() - static_cast<std::ptrdiff_t>(window);
  return median({history.end() - part, history.end()}) >= median({begin, begin + part});
}

/// One descent: the distribution N(mean, σ²C) and its paths, in the unit box; costs are minimised.
struct Descent {
  Descent(int n, int lambda, VectorXd start, double step)
      : p(n, lambda),
        mean(std::move(start)),
        sigma(step),
        C(MatrixXd::Identity(n, n)),
        B(MatrixXd::Identity(n, n)),
        D(VectorXd::Ones(n)),
        path_c(VectorXd::Zero(n)),
        path_sigma(VectorXd::Zero(n)),
        penalty(n) {}

  CmaParameters p;
  VectorXd mean;
  double sigma;
  MatrixXd C, B;  // C = B diag(D²) Bᵀ as of the last decomposition
  VectorXd D, path_c, path_sigma;
  BoundaryPenalty penalty;
  int updates = 0;  // generations that were not flat
  bool degenerate = false;
  std::vector<double> best_costs, median_costs;  // of each generation
  std::deque<double> mean_costs;                 // of the last generations

  void update(const std::vector<VectorXd>& z, const std::vector<double>& costs);
  /// A generation of equal costs selects nothing; the distribution only gets wider, up to the step size `widest`.
  void pass_flat(const std::vector<double>& costs, double widest);
  bool stagnated() const;
  /// Mean fitness over the last generations: what the distribution was worth where it ended.
  double merit() const {
    double sum = 0;
    for (const double cost : mean_costs) sum -= cost / static_cast<double>(mean_costs.size());
    return sum;
  }

 private:
  VectorXd shared_weights(const std::vector<double>& costs, bool positive_only) const;
  void record(const std::vector<double>& costs);
  void decompose();
};

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

bool Descent::stagnated() const {
  if (degenerate || !(sigma * std::sqrt(C.diagonal().maxCoeff()) > kSmallestStep)) return true;
  const auto least = static_cast<std::size_t>(120 + 30.0 * p.n / p.lambda);
  const auto window = std::clamp<std::size_t>(best_costs.size() / 5, least, 20000);
  return best_costs.size() >= window && stalled(best_costs, window) && stalled(median_costs, window);
}

class Cma final : public Optimizer {
 public:
  Cma(const OptimizerSettings& settings, const Bounds& bounds)
      : settings_(settings),
        n_(static_cast<int>(bounds.lower.size())),
        lower_(Eigen::Map<const VectorXd>(bounds.lower.data(), n_)),
        upper_(Eigen::Map<const VectorXd>(bounds.upper.data(), n_)),
        generation_(settings.population > 0 ? settings.population : default_population(bounds.lower.size())),
        descent_(start(0, generation_.size())) {}

  std::vector<Candidate> ask() const override {
    std::vector<Candidate> candidates;
    if (done()) return candidates;
    for (int k = 0; k < generation_.size(); ++k) candidates.push_back({generation_.number(), k, sample(k)});
    return candidates;
  }

  Status tell(int generation, int index, double fitness) override {
    PRIMO_ASSIGN(const bool fresh, generation_.tell(generation, index, fitness));
    if (!fresh) return success();
    ++evaluations_;
    if (generation_.complete()) advance();
    return success();
  }

  bool done() const override { return generation_.size() > settings_.evaluations - evaluations_ + told_now(); }
  std::string stop_reason() const override {
    if (!done()) return "";
    return "the budget of " + std::to_string(settings_.evaluations) + " evaluations is spent (" +
           std::to_string(settings_.evaluations - evaluations_) + " left, a generation is " +
           std::to_string(generation_.size()) + ")";
  }
  int evaluations() const override { return evaluations_; }
  std::vector<double> recommendation() const override {
    const bool present = kept_mean_.size() == 0 || (!descent_.mean_costs.empty() && descent_.merit() > kept_merit_);
    return in_box(present ? descent_.mean : kept_mean_);
  }
  std::vector<double> best() const override { return best_.x.empty() ? sample(0) : best_.x; }
  double best_fitness() const override { return best_.fitness; }
  double sigma() const override { return descent_.sigma; }

 private:
  /// Members of the present generation told so far; they are part of its cost already.
  int told_now() const { return evaluations_ - evaluations_before_; }

  Descent start(int run, int lambda) const {
    Random random(settings_.seed, "cma start",
                  {static_cast<std::uint64_t>(settings_.restart), static_cast<std::uint64_t>(run)});
    VectorXd mean(n_);
    for (auto& coordinate : mean) coordinate = random.uniform();
    return Descent(n_, lambda, mean, settings_.sigma);
  }

  VectorXd draw(int index) const {
    Random random(settings_.seed, "cma",
                  {static_cast<std::uint64_t>(settings_.restart), static_cast<std::uint64_t>(generation_.number()),
                   static_cast<std::uint64_t>(index)});
    VectorXd z(n_);
    for (auto& coordinate : z) coordinate = random.normal();
    return z;
  }

  std::vector<double> in_box(const VectorXd& u) const {
    const VectorXd x = (lower_ + repaired(u).cwiseProduct(upper_ - lower_)).cwiseMax(lower_).cwiseMin(upper_);
    return {x.begin(), x.end()};
  }

  std::vector<double> sample(int index) const {
    return in_box(descent_.mean + descent_.sigma * (descent_.B * descent_.D.cwiseProduct(draw(index))));
  }

  void advance() {
    std::vector<VectorXd> z;
    std::vector<double> costs;
    for (int k = 0; k < generation_.size(); ++k) {
      z.push_back(draw(k));
      costs.push_back(-generation_.fitness(k));
      best_.consider(sample(k), generation_.fitness(k));
      worst_ = std::min(worst_, generation_.fitness(k));
    }
    const auto [low, high] = std::minmax_element(costs.begin(), costs.end());
    if (*low < *high) {
      descent_.update(z, costs);
    } else {
      // On the highest plateau found the distribution stays as it is.
      const bool on_top = -*low == best_.fitness && worst_ < best_.fitness;
      descent_.pass_flat(costs, on_top ? descent_.sigma : settings_.sigma);
    }
    evaluations_before_ = evaluations_;
    int lambda = generation_.size();
    if (descent_.stagnated()) {
      keep_if_better();
      if (2 * lambda <= settings_.evaluations - evaluations_) lambda *= 2;
      descent_ = start(++run_, lambda);
    } else if (descent_.updates == 0) {
      keep_if_better();
      descent_ = start(++run_, lambda);  // nothing to descend here: look elsewhere
    }
    generation_.next(lambda);
  }

  void keep_if_better() {
    if (kept_mean_.size() > 0 && !(descent_.merit() > kept_merit_)) return;
    kept_mean_ = descent_.mean;
    kept_merit_ = descent_.merit();
  }

  OptimizerSettings settings_;
  int n_;
  VectorXd lower_, upper_;
  Generation generation_;
  Descent descent_;
  int run_ = 0;
  int evaluations_ = 0;         // all told
  int evaluations_before_ = 0;  // those of complete generations
  Best best_;
  double worst_ = INFINITY;
  VectorXd kept_mean_;  // of the best descent that stagnated; empty before the first
  double kept_merit_ = 0;
};

}  // namespace

std::unique_ptr<Optimizer> make_cma(const OptimizerSettings& settings, const Bounds& bounds) {
  return std::make_unique<Cma>(settings, bounds);
}

}  // namespace primo::optim
