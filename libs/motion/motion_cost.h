// A primitive's task costs on a robot in a scene: Φ_t of the paper's eq. 2, rows √ρ_{i,t} (φ_i(q) − y*_{i,t}).
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "core/result.h"
#include "motion/primitive.h"
#include "motion/task_variables.h"
#include "motion/trajectory_problem.h"

namespace primo::motion {

/// Not thread-safe: evaluate() uses a workspace. Robot, scene and primitive must outlive it.
class MotionCost final : public StageCosts {
 public:
  /// Targets that depart from the start are taken at q_start. Error config: a wrong variable, parameter or target size.
  static Result<std::unique_ptr<MotionCost>> create(const robot::Robot& robot, const PlanningScene& scene,
                                                    const Primitive& primitive, const Eigen::VectorXd& q_start);

  double evaluate(int t, const Eigen::VectorXd& q, const Eigen::VectorXd& v, StageModel* model) override;
  /// Those of the task variables, in the primitive's order. A pair that overlaps at q_start may do so less and less
  /// until the end, as soft tasks depart from their value there.
  int inequalities() const override { return inequalities_; }
  void inequality(int t, const Eigen::VectorXd& q, Eigen::VectorXd& c, Eigen::MatrixXd* J) override;

  /// The cost of each task over the path q (n × T), in the primitive's order.
  std::vector<TaskCost> task_costs(const Eigen::MatrixXd& q);
  /// What the i-th task's worst step is and why: "at step 52: finger_2_distal and c2 are -0.003 m apart".
  std::string explain(std::size_t task, const Eigen::MatrixXd& q);

 private:
  struct Term {
    const Task* task = nullptr;
    std::unique_ptr<TaskVariable> variable;
    Eigen::VectorXd target;     // y*, m
    Eigen::VectorXd departure;  // φ(q_0) − y* where the task departs from the start, else empty
    int late_from = 1;          // first late step
    int early_until = 1;        // last early step: at·T
    Eigen::VectorXd residual;   // workspace
    Jacobian J, J_v;            // workspace
    Eigen::VectorXd overlap;    // min(0, c(q_0)) of its inequalities
    Jacobian J_c;               // workspace of the inequalities
  };

  MotionCost(const robot::Robot& robot, const Primitive& primitive)
      : robot_(robot), steps_(primitive.steps), dt_(primitive.duration / primitive.steps) {}
  Status add(const PlanningScene& scene, const Primitive& primitive, const Task& task, const Eigen::VectorXd& q_start);
  double precision(const Term& term, int t) const;
  /// The share of y* that is the target at t.
  double target_share(const Term& term, int t) const;
  /// φ − y*_t into term.residual, rows that do not count zero; the Jacobian where asked for.
  void residual(Term& term, int t, const Configuration& at, bool with_jacobian) const;

  void add_rows(double rho, const Term& term, StageModel& model) const;
  void add_moving(double rho, const Term& term, StageModel& model) const;
  /// Calls visit(configuration, t) at a step of the path, or at every one.
  template <class F>
  void at_step(const Eigen::MatrixXd& q, int t, F&& visit);
  template <class F>
  void along(const Eigen::MatrixXd& q, F&& visit);

  const robot::Robot& robot_;
  const int steps_;
  const double dt_;  // s
  Eigen::VectorXd q_start_;
  std::vector<Term> terms_;
  int inequalities_ = 0;
  robot::Kinematics kinematics_;
};

}  // namespace primo::motion
