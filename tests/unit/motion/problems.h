// Trajectory problems with known answers, free of any robot.
#pragma once

#include <Eigen/Dense>
#include <cmath>
#include <vector>

#include "core/random.h"
#include "motion/trajectory_problem.h"

namespace primo::motion {

/// Φ_t(q, v) = J_t q + K_t v − y_t, scaled: everything is known about it. No K: nothing depends on v.
class LinearStages final : public StageCosts {
 public:
  std::vector<Eigen::MatrixXd> J, K;  // by t − 1
  std::vector<Eigen::VectorXd> y;
  double scale = 1;
  double evaluate(int t, const Eigen::VectorXd& q, const Eigen::VectorXd& v, StageModel* model) override {
    const Eigen::MatrixXd& Jt = J[t - 1];
    Eigen::VectorXd phi = Jt * q - y[t - 1];
    if (!K.empty()) phi += K[t - 1] * v;
    if (model) {
      model->R_qq = scale * Jt.transpose() * Jt;
      model->r_q = scale * Jt.transpose() * phi;
      model->moving = !K.empty();
      if (model->moving) {
        model->R_vq = scale * K[t - 1].transpose() * Jt;
        model->R_vv = scale * K[t - 1].transpose() * K[t - 1];
        model->r_v = scale * K[t - 1].transpose() * phi;
      }
    }
    return scale * phi.squaredNorm();
  }
};

/// (sin q₁ + q₂² − y)² and the like: smooth, curved, with minima along valleys.
class CurvedStages final : public StageCosts {
 public:
  double scale = 1;
  double evaluate(int t, const Eigen::VectorXd& q, const Eigen::VectorXd&, StageModel* model) override {
    const Eigen::Vector2d phi(3 * (std::sin(q[0]) + q[1] * q[1] - 0.1 * t), q[0] * q[1] - 0.5);
    Eigen::Matrix2d J;
    J << 3 * std::cos(q[0]), 6 * q[1], q[1], q[0];
    if (model) {
      model->R_qq = scale * J.transpose() * J;
      model->r_q = scale * J.transpose() * phi;
    }
    return scale * phi.squaredNorm();
  }
};

/// Random weights and start.
inline TrajectoryProblem make_problem(int n, int T, std::uint64_t seed) {
  Random random(seed, "solver_test");
  TrajectoryProblem problem;
  problem.steps = T;
  problem.dt = 0.1;
  problem.H.resize(n);
  problem.q_start.resize(n);
  problem.v_start.resize(n);
  for (int i = 0; i < n; ++i) {
    problem.H[i] = random.uniform(0.01, 0.3);
    problem.q_start[i] = random.normal();
    problem.v_start[i] = random.normal();
  }
  return problem;
}

/// A vector of one entry.
inline Eigen::VectorXd scalar(double value) {
  Eigen::VectorXd vector(1);
  vector[0] = value;
  return vector;
}

/// Random linear tasks with precisions over `decades` decades.
inline LinearStages make_linear(int n, int T, double decades, std::uint64_t seed) {
  Random random(seed, "solver_test linear");
  LinearStages stages;
  for (int t = 0; t < T; ++t) {
    Eigen::MatrixXd J(3, n);
    Eigen::VectorXd y(3);
    for (int row = 0; row < 3; ++row) {
      const double root = std::pow(10, 0.5 * random.uniform(-decades / 2, decades / 2));
      for (int i = 0; i < n; ++i) J(row, i) = root * random.normal();
      y[row] = root * random.normal();
    }
    stages.J.push_back(J);
    stages.y.push_back(y);
  }
  return stages;
}

/// The same with tasks that depend on velocities too.
inline LinearStages make_moving(int n, int T, double decades, std::uint64_t seed) {
  LinearStages stages = make_linear(n, T, decades, seed);
  stages.K = make_linear(n, T, decades, seed + 1000).J;
  return stages;
}

/// The exact minimum of a linear problem as one dense least-squares problem, in long double.
inline Eigen::MatrixXd dense_solution(const TrajectoryProblem& problem, const LinearStages& stages) {
  using Matrix = Eigen::Matrix<long double, Eigen::Dynamic, Eigen::Dynamic>;
  using Vector = Eigen::Matrix<long double, Eigen::Dynamic, 1>;
  const int n = problem.joints(), T = problem.steps;
  const long double tau = problem.dt;
  Matrix A = Matrix::Zero(n * T + 3 * T, n * T);
  Vector b = Vector::Zero(n * T + 3 * T);
  for (int t = 0; t < T; ++t) {
    for (int i = 0; i < n; ++i) {
      const int row = t * n + i;
      const long double root = std::sqrt(static_cast<long double>(problem.H[i])) / (tau * tau);
      const long double q0 = problem.q_start[i], q_before = q0 - tau * problem.v_start[i];
      A(row, t * n + i) = root;
      if (t == 0) b[row] = root * (2 * q0 - q_before);
      if (t >= 1) A(row, (t - 1) * n + i) = -2 * root;
      if (t == 1) b[row] = -root * q0;
      if (t >= 2) A(row, (t - 2) * n + i) = root;
    }
    A.block(n * T + 3 * t, t * n, 3, n) = stages.J[t].cast<long double>();
    b.segment(n * T + 3 * t, 3) = stages.y[t].cast<long double>();
    if (stages.K.empty()) continue;
    const Matrix K = stages.K[t].cast<long double>() / tau;  // v_t = (q_t − q_{t−1}) / τ
    A.block(n * T + 3 * t, t * n, 3, n) += K;
    if (t > 0) {
      A.block(n * T + 3 * t, (t - 1) * n, 3, n) = -K;
    } else {
      b.segment(n * T, 3) += K * problem.q_start.cast<long double>();
    }
  }
  const Vector x = A.householderQr().solve(b);
  return Eigen::Map<const Matrix>(x.data(), n, T).cast<double>();
}

/// Undamped, until nothing moves.
inline SolverOptions exact() {
  SolverOptions options;
  options.step_tolerance = 1e-10;
  options.cost_tolerance = 0;
  options.lambda_initial = 0;
  return options;
}

/// The textbook recursion for x⁺ = A x + B u with cost ρ q² a step and h u² a control.
inline Eigen::RowVector2d point_mass_gains(double tau, double h, double rho, int T,
                                           std::vector<Eigen::RowVector2d>& K) {
  Eigen::Matrix2d A, Q = Eigen::Matrix2d::Zero();
  A << 1, tau, 0, 1;
  const Eigen::Vector2d B(tau * tau, tau);
  Q(0, 0) = rho;
  Eigen::Matrix2d P = Q;
  K.assign(T, Eigen::RowVector2d::Zero());
  for (int t = T - 1; t >= 0; --t) {
    K[t] = -(B.transpose() * P * A) / (h + B.dot(P * B));
    P = Q + A.transpose() * P * (A + B * K[t]);
  }
  return K[0];
}

/// ρ q² at every step.
inline LinearStages point_mass_stages(int T, double rho) {
  LinearStages stages;
  stages.J.assign(T, Eigen::MatrixXd::Constant(1, 1, std::sqrt(rho)));
  stages.y.assign(T, scalar(0));
  return stages;
}

/// A planar arm of two links: its tip reaches a goal at the last step, away from a round obstacle at every step.
class PlanarStages final : public StageCosts {
 public:
  static constexpr double kFirst = 1.0, kSecond = 0.8;  // m
  int steps = 1;
  double rho = 1, rho_obstacle = 0;
  Eigen::Vector2d goal{0, 0}, obstacle{0, 0};  // m
  double radius = 0.3;                         // m
  bool hard = false;                           // whether the obstacle is an inequality too

  static Eigen::Vector2d tip(const Eigen::VectorXd& q, Eigen::Matrix2d* J = nullptr) {
    const double a = q[0], b = q[0] + q[1];
    if (J)
      *J << -kFirst * std::sin(a) - kSecond * std::sin(b), -kSecond * std::sin(b),
          kFirst * std::cos(a) + kSecond * std::cos(b), kSecond * std::cos(b);
    return {kFirst * std::cos(a) + kSecond * std::cos(b), kFirst * std::sin(a) + kSecond * std::sin(b)};
  }
  /// The joint angles at a tip, elbow with q₂ ≥ 0.
  static Eigen::Vector2d inverse(const Eigen::Vector2d& p) {
    const double c = (p.squaredNorm() - kFirst * kFirst - kSecond * kSecond) / (2 * kFirst * kSecond);
    const double elbow = std::acos(c);
    return {std::atan2(p.y(), p.x()) - std::atan2(kSecond * std::sin(elbow), kFirst + kSecond * std::cos(elbow)),
            elbow};
  }

  double evaluate(int t, const Eigen::VectorXd& q, const Eigen::VectorXd&, StageModel* model) override {
    Eigen::Matrix2d J;
    const Eigen::Vector2d p = tip(q, &J);
    Eigen::Vector3d phi = Eigen::Vector3d::Zero();
    Eigen::Matrix<double, 3, 2> slope = Eigen::Matrix<double, 3, 2>::Zero();
    if (t == steps) {
      phi.head<2>() = std::sqrt(rho) * (p - goal);
      slope.topRows<2>() = std::sqrt(rho) * J;
    }
    const double distance = std::max(1e-6, (p - obstacle).norm());
    if (distance < radius) {
      phi[2] = std::sqrt(rho_obstacle) * (1 - distance / radius);
      slope.row(2) = -std::sqrt(rho_obstacle) / (radius * distance) * (p - obstacle).transpose() * J;
    }
    if (model) {
      model->R_qq = slope.transpose() * slope;
      model->r_q = slope.transpose() * phi;
    }
    return phi.squaredNorm();
  }

  int inequalities() const override { return hard ? 1 : 0; }
  void inequality(int, const Eigen::VectorXd& q, Eigen::VectorXd& c, Eigen::MatrixXd* J) override {
    Eigen::Matrix2d slope;
    const Eigen::Vector2d away = tip(q, &slope) - obstacle;
    const double distance = std::max(1e-6, away.norm()), cut = 2 * radius;
    c[0] = std::min(distance, cut) - radius;
    if (!J) return;
    J->setZero();
    if (distance < cut) J->row(0) = away.transpose() / distance * slope;
  }
};

}  // namespace primo::motion
