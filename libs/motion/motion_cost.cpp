#include "motion/motion_cost.h"

#include <algorithm>
#include <cmath>

namespace primo::motion {

Result<std::unique_ptr<MotionCost>> MotionCost::create(const robot::Robot& robot, const PlanningScene& scene,
                                                       const Primitive& primitive, const Eigen::VectorXd& q_start) {
  std::unique_ptr<MotionCost> cost(new MotionCost(robot, primitive));
  cost->q_start_ = q_start;
  for (const auto& task : primitive.tasks) {
    if (auto status = cost->add(scene, primitive, task, q_start); !status.ok()) {
      return status.error().at("task '" + task.name + "'");
    }
  }
  return cost;
}

Status MotionCost::add(const PlanningScene& scene, const Primitive& primitive, const Task& task,
                       const Eigen::VectorXd& q_start) {
  Term term;
  term.task = &task;
  PRIMO_ASSIGN(term.variable, make_task_variable(task, robot_, scene));
  const int m = term.variable->size();
  term.target = Eigen::VectorXd::Zero(m);
  if (task.target.size() == 1) {
    term.target.setConstant(task.target[0]);
  } else if (static_cast<int>(task.target.size()) == m) {
    term.target = Eigen::Map<const Eigen::VectorXd>(task.target.data(), m);
  } else if (!task.target.empty()) {
    return Error{Code::config, "target has " + std::to_string(task.target.size()) + " entries, expected " +
                                   std::to_string(m) + ", 1 (for all) or none (zero)"};
  }
  const double late = task.profile == Profile::final ? primitive.steps : task.at * primitive.steps;
  term.late_from = std::clamp(static_cast<int>(std::ceil(late - 1e-9)), 1, primitive.steps);
  term.early_until = std::clamp(static_cast<int>(std::floor(task.at * primitive.steps + 1e-9)), 1, primitive.steps);
  term.residual.resize(m);
  term.J.resize(m, robot_.joints());
  if (term.variable->moving()) term.J_v.resize(m, robot_.joints());
  if (task.from_start || term.variable->departs_from_start()) {
    robot_.forward(q_start, kinematics_);
    term.departure.resize(m);
    const Eigen::VectorXd still = Eigen::VectorXd::Zero(robot_.joints());
    term.variable->evaluate({q_start, kinematics_, 0.0, still, dt_}, term.departure, nullptr);
    term.departure -= term.target;
  }
  if (const int inequalities = term.variable->inequalities(); inequalities > 0) {
    robot_.forward(q_start, kinematics_);
    const Eigen::VectorXd still = Eigen::VectorXd::Zero(robot_.joints());
    term.overlap.resize(inequalities);
    term.J_c.resize(inequalities, robot_.joints());
    term.variable->inequality({q_start, kinematics_, 0.0, still, dt_}, term.overlap, nullptr);
    term.overlap = term.overlap.cwiseMin(0);
    inequalities_ += inequalities;
  }
  terms_.push_back(std::move(term));
  return success();
}

double MotionCost::precision(const Term& term, int t) const {
  const bool late = t >= term.late_from;
  switch (term.task->profile) {
    case Profile::constant:
      return term.task->rho;
    case Profile::final:
    case Profile::late:
      return late ? term.task->rho : 0;
    case Profile::early_late:
    case Profile::ramp:
      return late ? term.task->rho_late : term.task->rho;
    case Profile::early:
      return t <= term.early_until ? term.task->rho : 0;
    case Profile::ends:
      return t <= term.early_until || t >= steps_ - term.early_until ? term.task->rho : 0;
  }
  return 0;
}

double MotionCost::target_share(const Term& term, int t) const {
  if (term.task->profile == Profile::ramp) {
    if (t < term.late_from) return 0;
    return term.late_from == steps_ ? 1.0 : static_cast<double>(t - term.late_from) / (steps_ - term.late_from);
  }
  if (term.task->profile == Profile::ends) {
    const double w = term.early_until;
    return 2 * t <= steps_ ? t / w : -(steps_ - t) / w;
  }
  return 1;
}

void MotionCost::residual(Term& term, int t, const Configuration& at, bool with_jacobian) const {
  term.variable->evaluate(at, term.residual, with_jacobian && !term.variable->is_identity() ? &term.J : nullptr);
  if (with_jacobian && term.variable->moving()) term.variable->velocity_jacobian(at, term.J_v);
  term.residual -= target_share(term, t) * term.target;
  if (term.departure.size() > 0) term.residual -= (1 - at.phase) * term.departure;
  for (int row = 0, rows = static_cast<int>(term.residual.size()); row < rows; ++row) {
    if (term.variable->counts(row, at.phase)) continue;
    term.residual[row] = 0;
    if (!with_jacobian) continue;
    term.J.row(row).setZero();
    if (term.variable->moving()) term.J_v.row(row).setZero();
  }
}

double MotionCost::evaluate(int t, const Eigen::VectorXd& q, const Eigen::VectorXd& v, StageModel* model) {
  const int n = robot_.joints();
  if (model) {
    model->R_qq.setZero(n, n);
    model->r_q.setZero(n);
    model->moving = false;
  }
  robot_.forward(q, kinematics_);
  const Configuration at{q, kinematics_, static_cast<double>(t) / steps_, v, dt_};
  double cost = 0;
  for (auto& term : terms_) {
    const double rho = precision(term, t);
    if (rho <= 0) continue;
    residual(term, t, at, model != nullptr);
    cost += rho * term.residual.squaredNorm();
    if (!model) continue;
    if (term.variable->is_identity()) {
      model->R_qq.diagonal().array() += rho;
      model->r_q += rho * term.residual;
      continue;
    }
    if (term.variable->moving()) add_moving(rho, term, *model);
    add_rows(rho, term, *model);
  }
  return cost;
}

void MotionCost::inequality(int t, const Eigen::VectorXd& q, Eigen::VectorXd& c, Eigen::MatrixXd* J) {
  robot_.forward(q, kinematics_);
  const Eigen::VectorXd still = Eigen::VectorXd::Zero(robot_.joints());
  const Configuration at{q, kinematics_, static_cast<double>(t) / steps_, still, dt_};
  Eigen::Index row = 0;
  for (auto& term : terms_) {
    const Eigen::Index rows = term.overlap.size();
    if (rows == 0) continue;
    term.variable->inequality(at, c.segment(row, rows), J ? &term.J_c : nullptr);
    c.segment(row, rows) -= (1 - at.phase) * term.overlap;
    if (J) J->middleRows(row, rows) = term.J_c;
    row += rows;
  }
}

/// R_qq += ρ JᵀJ and r_q += ρ Jᵀ(φ − y*), the lower triangle.
void MotionCost::add_rows(double rho, const Term& term, StageModel& model) const {
  const Eigen::Index n = term.J.cols();
  for (Eigen::Index row = 0; row < term.J.rows(); ++row) {
    const double* J = term.J.row(row).data();
    // Rows touch a stretch of the joints, or none: beyond the margin of a proximity all are zero.
    Eigen::Index first = 0, last = n;
    while (first < n && J[first] == 0) ++first;
    while (last > first && J[last - 1] == 0) --last;
    const double weighted = rho * term.residual[row];
    for (Eigen::Index j = first; j < last; ++j) {
      if (J[j] == 0) continue;
      model.r_q[j] += weighted * J[j];
      const double factor = rho * J[j];
      double* column = model.R_qq.data() + j * n;
      for (Eigen::Index i = j; i < last; ++i) column[i] += factor * J[i];
    }
  }
}

/// The blocks of R and r that belong to v.
void MotionCost::add_moving(double rho, const Term& term, StageModel& model) const {
  const int n = robot_.joints();
  if (!model.moving) {
    model.R_vq.setZero(n, n);
    model.R_vv.setZero(n, n);
    model.r_v.setZero(n);
    model.moving = true;
  }
  model.R_vq.noalias() += rho * term.J_v.transpose() * term.J;
  model.R_vv.noalias() += rho * term.J_v.transpose() * term.J_v;
  model.r_v.noalias() += rho * term.J_v.transpose() * term.residual;
}

template <class F>
void MotionCost::at_step(const Eigen::MatrixXd& q, int t, F&& visit) {
  const Eigen::VectorXd q_t = q.col(t - 1);
  const Eigen::VectorXd q_before = t == 1 ? q_start_ : Eigen::VectorXd(q.col(t - 2));
  const Eigen::VectorXd v_t = (q_t - q_before) / dt_;
  robot_.forward(q_t, kinematics_);
  visit(Configuration{q_t, kinematics_, static_cast<double>(t) / steps_, v_t, dt_}, t);
}

template <class F>
void MotionCost::along(const Eigen::MatrixXd& q, F&& visit) {
  for (int t = 1; t <= steps_; ++t) at_step(q, t, visit);
}

std::vector<TaskCost> MotionCost::task_costs(const Eigen::MatrixXd& q) {
  std::vector<TaskCost> costs;
  for (const auto& term : terms_) costs.push_back({term.task->name, 0});
  along(q, [&](const Configuration& at, int t) {
    for (std::size_t i = 0; i < terms_.size(); ++i) {
      const double rho = precision(terms_[i], t);
      if (rho <= 0) continue;
      residual(terms_[i], t, at, false);
      costs[i].cost += rho * terms_[i].residual.squaredNorm();
    }
  });
  return costs;
}

std::string MotionCost::explain(std::size_t task, const Eigen::MatrixXd& q) {
  Term& term = terms_[task];
  double worst = -1;
  int worst_step = 0;
  along(q, [&](const Configuration& at, int t) {
    const double rho = precision(term, t);
    if (rho <= 0) return;
    residual(term, t, at, false);
    const double cost = rho * term.residual.squaredNorm();
    if (cost <= worst) return;
    worst = cost;
    worst_step = t;
  });
  std::string text;
  if (worst_step > 0) at_step(q, worst_step, [&](const Configuration& at, int) { text = term.variable->explain(at); });
  return "most at step " + std::to_string(worst_step) + (text.empty() ? "" : ", where " + text);
}

}  // namespace primo::motion
