#include "optim/boundary.h"

#include <algorithm>
#include <cmath>

namespace primo::optim {
namespace {

constexpr double kLargest = 1e300;
constexpr double kDecay = 0.7;  // a generation

double median(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

}  // namespace

void BoundaryPenalty::adapt(const std::vector<double>& costs, const Eigen::VectorXd& mean, double sigma,
                            const Eigen::VectorXd& c_diagonal, double mu_eff) {
  const auto n = static_cast<double>(mean.size());
  std::vector<double> sorted = costs;
  std::sort(sorted.begin(), sorted.end());
  // A flat generation tells nothing of the scale of the costs.
  const double spread = sorted[(3 * sorted.size()) / 4] - sorted[sorted.size() / 4];
  if (spread > 0) spreads_.push_back(std::min(spread, kLargest));
  const auto keep = static_cast<std::size_t>(20 + 3 * n / static_cast<double>(costs.size()));
  while (spreads_.size() > keep) spreads_.pop_front();

  const Eigen::VectorXd outside = (mean - repaired(mean)).cwiseAbs();
  if (spreads_.empty() || (!active_ && outside.maxCoeff() == 0)) return;
  const double scale = median({spreads_.begin(), spreads_.end()});
  const double fresh = std::min(2 * scale / (sigma * sigma * c_diagonal.mean()), kLargest);
  if (!active_) {
    weights_.setConstant(fresh);
    active_ = true;
  }
  const double growth = std::pow(1.1, std::max(1.0, mu_eff / (10 * n)));
  for (Eigen::Index i = 0; i < mean.size(); ++i) {
    if (outside[i] > 3 * sigma * std::sqrt(c_diagonal[i]) * std::max(1.0, std::sqrt(n) / mu_eff)) {
      weights_[i] = std::min(weights_[i] * growth, kLargest);
    } else if (weights_[i] > fresh) {
      weights_[i] *= kDecay;  // one from when costs differed by more would hide what they differ by now
    }
  }
}

double BoundaryPenalty::operator()(const Eigen::VectorXd& u, const Eigen::VectorXd& c_diagonal) const {
  if (!active_) return 0;
  const auto n = static_cast<double>(u.size());
  const double mean_log = c_diagonal.array().log().mean();
  const Eigen::ArrayXd scale = (0.9 * (c_diagonal.array().log() - mean_log)).exp();
  const Eigen::ArrayXd distance = (u - repaired(u)).array();
  const double penalty = (weights_.array() * distance.square() / scale).sum() / n;
  return std::isfinite(penalty) ? std::min(penalty, kLargest) : kLargest;
}

void BoundaryPenalty::save(State& state) const {
  state["penalty_weights"] = active_ ? flat(weights_) : std::vector<double>{};
  state["penalty_spreads"] = {spreads_.begin(), spreads_.end()};
}

Status BoundaryPenalty::load(const StateReader& state, int dimension) {
  PRIMO_ASSIGN(const auto weights, state.numbers("penalty_weights"));
  PRIMO_ASSIGN(const auto spreads, state.numbers("penalty_spreads"));
  const auto n = static_cast<std::size_t>(dimension);
  active_ = !weights.empty();
  if ((active_ && weights.size() != n) || spreads.size() > 20 + 3 * n) {
    return Error{Code::data, "the optimizer's state: 'penalty_weights' or 'penalty_spreads' has a wrong size"};
  }
  weights_.setZero(dimension);
  if (active_) weights_ = Eigen::Map<const Eigen::VectorXd>(weights.data(), dimension);
  spreads_.assign(spreads.begin(), spreads.end());
  return success();
}

}  // namespace primo::optim
