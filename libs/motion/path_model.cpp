#include "motion/path_model.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "core/check.h"

namespace primo::motion {
namespace {

/// Adds the part of a step's Hessian that comes from v_t = (q_t − q_{t−1}) / τ.
void add_moving(const TrajectoryProblem& problem, const StageModel& model, int t, BandMatrix& band) {
  if (!model.moving) return;
  const int n = problem.joints();
  const double by_tau = 1 / problem.dt;
  const Eigen::MatrixXd vv = by_tau * by_tau * Eigen::MatrixXd(model.R_vv.selfadjointView<Eigen::Lower>());
  for (int j = 0; j < n; ++j) {
    for (int i = j; i < n; ++i)
      band.at(t * n + i, t * n + j) += by_tau * (model.R_vq(i, j) + model.R_vq(j, i)) + vv(i, j);
    if (t == 0) continue;
    for (int i = j; i < n; ++i) band.at((t - 1) * n + i, (t - 1) * n + j) += vv(i, j);
    for (int i = 0; i < n; ++i) band.at(t * n + i, (t - 1) * n + j) -= by_tau * model.R_vq(j, i) + vv(i, j);
  }
}

}  // namespace

Eigen::MatrixXd velocities(const TrajectoryProblem& problem, const Eigen::MatrixXd& q) {
  PRIMO_CHECK(q.rows() == problem.joints() && q.cols() == problem.steps, "a path has one column for each step 1 … T");
  Eigen::MatrixXd v(q.rows(), q.cols());
  v.col(0) = (q.col(0) - problem.q_start) / problem.dt;
  for (Eigen::Index t = 1; t < q.cols(); ++t) v.col(t) = (q.col(t) - q.col(t - 1)) / problem.dt;
  return v;
}

Eigen::MatrixXd controls(const TrajectoryProblem& problem, const Eigen::MatrixXd& q) {
  const Eigen::Index T = problem.steps;
  PRIMO_CHECK(q.rows() == problem.joints() && q.cols() == T, "a path has one column for each step 1 … T");
  Eigen::MatrixXd u(q.rows(), T);
  const double inverse = 1 / (problem.dt * problem.dt);
  for (Eigen::Index t = 0; t < T; ++t) {
    if (t == 0) {
      u.col(0) = inverse * (q.col(0) - problem.q_start - problem.dt * problem.v_start);
    } else if (t == 1) {
      u.col(1) = inverse * (q.col(1) - 2 * q.col(0) + problem.q_start);
    } else {
      u.col(t) = inverse * (q.col(t) - 2 * q.col(t - 1) + q.col(t - 2));
    }
  }
  return u;
}

double control_cost(const TrajectoryProblem& problem, const Eigen::MatrixXd& q) {
  return (controls(problem, q).array().square().colwise() * problem.H.array()).sum();
}

bool evaluate(const TrajectoryProblem& problem, StageCosts& stages, PathModel& path, double limit) {
  path.cost_control = control_cost(problem, path.q);
  path.cost = path.cost_control;
  path.models.resize(problem.steps);
  const Eigen::MatrixXd v = velocities(problem, path.q);
  Eigen::VectorXd q_t, v_t;
  for (int t = 0; t < problem.steps; ++t) {
    if (!(path.cost < limit)) return false;
    q_t = path.q.col(t);
    v_t = v.col(t);
    StageModel& model = path.models[t];
    path.cost += stages.evaluate(t + 1, q_t, v_t, &model);
    if (!model.r_q.allFinite() || (model.moving && !model.r_v.allFinite())) return false;
  }
  return path.cost < limit && std::isfinite(path.cost);
}

Eigen::VectorXd half_gradient(const TrajectoryProblem& problem, const PathModel& path) {
  const int n = problem.joints(), T = problem.steps;
  const Eigen::MatrixXd u = controls(problem, path.q);
  Eigen::MatrixXd g(n, T);
  const Eigen::VectorXd weight = problem.H / (problem.dt * problem.dt);
  for (int t = 1; t <= T; ++t) {  // q_t enters u_{t−1}, u_t and u_{t+1}
    g.col(t - 1) = path.models[t - 1].r_q + weight.cwiseProduct(u.col(t - 1));
    if (t < T) g.col(t - 1) -= 2 * weight.cwiseProduct(u.col(t));
    if (t + 1 < T) g.col(t - 1) += weight.cwiseProduct(u.col(t + 1));
  }
  for (int t = 0; t < T; ++t) {
    if (!path.models[t].moving) continue;
    g.col(t) += path.models[t].r_v / problem.dt;
    if (t > 0) g.col(t - 1) -= path.models[t].r_v / problem.dt;
  }
  return Eigen::Map<const Eigen::VectorXd>(g.data(), g.size());
}

Eigen::VectorXd control_curvature(const TrajectoryProblem& problem) { return problem.H / std::pow(problem.dt, 4); }

void assemble_hessian(const TrajectoryProblem& problem, const std::vector<StageModel>& models, double damping,
                      BandMatrix& band) {
  const int n = problem.joints(), T = problem.steps, size = n * T;
  const Eigen::VectorXd curvature = control_curvature(problem);
  for (int t = 0; t < T; ++t) {
    const double diagonal = 1 + (t + 1 < T ? 4 : 0) + (t + 2 < T ? 1 : 0);
    for (int j = 0; j < n; ++j) {
      const int column = t * n + j;
      for (int row = column; row <= std::min(size - 1, column + band.width()); ++row) band.at(row, column) = 0;
      for (int i = j; i < n; ++i) band.at(t * n + i, column) = models[t].R_qq(i, j);
      band.at(column, column) += diagonal * curvature[j] + damping;
      if (t + 1 < T) band.at(column + n, column) = (t + 2 < T ? -4 : -2) * curvature[j];
      if (t + 2 < T) band.at(column + 2 * n, column) = curvature[j];
    }
  }
  for (int t = 0; t < T; ++t) add_moving(problem, models[t], t, band);
}

bool begin(const TrajectoryProblem& problem, StageCosts& stages, PathModel& path, Solution& solution) {
  if (!path.q.allFinite()) return false;
  ++solution.evaluations;
  const bool finite = evaluate(problem, stages, path, std::numeric_limits<double>::max());
  if (finite) solution.cost_initial = path.cost;
  return finite;
}

void finish(const TrajectoryProblem& problem, PathModel&& path, bool finite, Solution& solution) {
  if (!finite) solution.status = PlanStatus::bad_input;
  if (finite) solution.gradient_norm = half_gradient(problem, path).cwiseAbs().maxCoeff();
  solution.cost = finite ? path.cost : 0;
  solution.cost_control = finite ? path.cost_control : 0;
  solution.q = std::move(path.q);
  solution.models = std::move(path.models);
}

}  // namespace primo::motion
