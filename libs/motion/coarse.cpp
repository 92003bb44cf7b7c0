#include "motion/coarse.h"

#include <algorithm>
#include <cmath>

#include "core/check.h"

namespace primo::motion {
namespace {

void scale(StageModel& model, double weight) {
  model.R_qq *= weight;
  model.r_q *= weight;
  if (!model.moving) return;
  model.R_vq *= weight;
  model.R_vv *= weight;
  model.r_v *= weight;
}

/// model += weight · other; only one of them may depend on v.
void add(StageModel& model, double weight, const StageModel& other) {
  model.R_qq += weight * other.R_qq;
  model.r_q += weight * other.r_q;
  if (!other.moving) return;
  if (!model.moving) {
    const auto n = model.r_q.size();
    model.R_vq.setZero(n, n);
    model.R_vv.setZero(n, n);
    model.r_v.setZero(n);
    model.moving = true;
  }
  model.R_vq += weight * other.R_vq;
  model.R_vv += weight * other.R_vv;
  model.r_v += weight * other.r_v;
}

}  // namespace

CoarseStages::CoarseStages(const TrajectoryProblem& fine, StageCosts& stages, int steps)
    : fine_(fine), stages_(stages), problem_(fine), at_(static_cast<std::size_t>(steps)), weight_(at_.size()) {
  PRIMO_CHECK(steps >= 1 && steps <= fine.steps, "a coarse path has 1 … T steps");
  const double ratio = static_cast<double>(fine.steps) / steps;
  problem_.steps = steps;
  problem_.dt *= ratio;
  problem_.H *= ratio;
  for (std::size_t k = 0; k < at_.size(); ++k)
    at_[k] = static_cast<int>(std::lround(ratio * static_cast<double>(k + 1)));
  for (std::size_t k = 0; k < at_.size(); ++k) {
    const int before = k > 0 ? at_[k - 1] : 0;
    weight_[k] = k + 1 < at_.size() ? 0.5 * (at_[k + 1] - before) : 0.5 * (at_[k] - before + 1);
  }
}

double CoarseStages::evaluate(int k, const Eigen::VectorXd& q, const Eigen::VectorXd& v, StageModel* model) {
  const auto i = static_cast<std::size_t>(k - 1);
  double cost = stages_.evaluate(at_[i], q, v, model);
  if (k < problem_.steps) {
    if (model) scale(*model, weight_[i]);
    return weight_[i] * cost;
  }
  const double others = weight_[i] - 1;
  if (!(others > 0) || fine_.steps < 2) return cost;
  cost += others * stages_.evaluate(fine_.steps - 1, q, v, model ? &before_ : nullptr);
  if (model) add(*model, others, before_);
  return cost;
}

Eigen::MatrixXd CoarseStages::sample(const Eigen::MatrixXd& q) const {
  Eigen::MatrixXd points(q.rows(), problem_.steps);
  for (Eigen::Index k = 0; k < points.cols(); ++k) points.col(k) = q.col(at_[static_cast<std::size_t>(k)] - 1);
  return points;
}

Eigen::MatrixXd CoarseStages::refine(const Eigen::MatrixXd& q) const {
  const Eigen::Index n = q.rows(), K = q.cols();
  const auto knot = [&](Eigen::Index k) { return k == 0 ? fine_.q_start : Eigen::VectorXd(q.col(k - 1)); };
  const auto time = [&](Eigen::Index k) { return k == 0 ? 0.0 : fine_.dt * at_[static_cast<std::size_t>(k - 1)]; };
  // The second derivatives m_0 … m_K by the Thomas algorithm:
  //   h_k m_{k−1} + 2 (h_k + h_{k+1}) m_k + h_{k+1} m_{k+1} = 6 (s_{k+1} − s_k),  s_k the slope of interval k,
  // with 2 h_1 m_0 + h_1 m_1 = 6 (s_1 − v_0) and m_K = 0.
  Eigen::MatrixXd m = Eigen::MatrixXd::Zero(n, K + 1);
  Eigen::VectorXd upper = Eigen::VectorXd::Zero(K + 1), slope = fine_.v_start;
  double h_before = 0;
  for (Eigen::Index k = 0; k < K; ++k) {
    const double h = time(k + 1) - time(k);
    const Eigen::VectorXd next = (knot(k + 1) - knot(k)) / h;
    const double pivot = 2 * (h_before + h) - (k > 0 ? h_before * upper[k - 1] : 0);
    m.col(k) = 6 * (next - slope);
    if (k > 0) m.col(k) -= h_before * m.col(k - 1);
    m.col(k) /= pivot;
    upper[k] = h / pivot;
    slope = next;
    h_before = h;
  }
  for (Eigen::Index k = K - 1; k >= 0; --k) m.col(k) -= upper[k] * m.col(k + 1);
  Eigen::MatrixXd path(n, fine_.steps);
  Eigen::Index k = 0;
  for (int t = 1; t <= fine_.steps; ++t) {
    if (t > at_[static_cast<std::size_t>(k)]) ++k;
    const double h = time(k + 1) - time(k), b = (fine_.dt * t - time(k)) / h, a = 1 - b;
    path.col(t - 1) =
        a * knot(k) + b * knot(k + 1) + h * h / 6 * ((a * a * a - a) * m.col(k) + (b * b * b - b) * m.col(k + 1));
  }
  return path;
}

}  // namespace primo::motion
