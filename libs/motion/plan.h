// What a planner is asked and what it answers.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

#include "config/config.h"
#include "motion/planning_scene.h"
#include "motion/primitive.h"
#include "scene/estimate.h"

namespace primo::motion {

/// Why a solver stopped. Only the first two are convergence.
enum class PlanStatus {
  converged_step,
  converged_cost,
  iteration_limit,
  damping_limit,
  factorisation_failed,
  bad_input,
  infeasible  ///< hard constraints cannot be met from this start
};
}  // namespace primo::motion

template <>
struct primo::config::EnumNames<primo::motion::PlanStatus> {
  static constexpr std::array<std::string_view, 7> names = {"converged_step", "converged_cost",       "iteration_limit",
                                                            "damping_limit",  "factorisation_failed", "bad_input",
                                                            "infeasible"};
};

namespace primo::motion {

/// A joint-space motion. Row t of q is q_t, t = 0 … T, in the robot file's joint order.
struct Trajectory {
  std::vector<std::string> joints;
  double dt = 0;      ///< s between rows
  Eigen::MatrixXd q;  ///< rad, (T+1) × n
};

/// Linear feedback u_t = k_t + K_t (x_t − x̂_t) around the plan, x = (q, q̇), u = q̈.
struct Gains {
  std::vector<Eigen::MatrixXd> K;  ///< T of n × 2n
  std::vector<Eigen::VectorXd> k;  ///< T of n, rad/s²
};

struct PlanRequest {
  scene::SceneEstimate scene;
  std::vector<std::string> action;  ///< name and arguments: [grasp, c1]
  std::vector<double> q_start;      ///< rad
  Primitive primitive;
  bool want_gains = false;
  Eigen::MatrixXd last;                 ///< rad, rows q_0 … q_T' of the last plan; only start `last` needs it
  std::optional<HeldObject> held = {};  ///< what the hand holds throughout
};

struct TaskCost {
  std::string task;
  double cost = 0;
};

struct Plan {
  PlanStatus status = PlanStatus::bad_input;
  std::string reason;     ///< one sentence, also on success
  Trajectory trajectory;  ///< empty on bad_input
  Gains gains;            ///< empty unless asked for
  int iterations = 0;     ///< accepted steps
  int rejected = 0;       ///< rejected steps
  int evaluations = 0;
  double cost_initial = 0, cost_final = 0, cost_control = 0;
  std::vector<TaskCost> cost_tasks;  ///< in the primitive's order
  double gradient_norm = 0;
  double lambda = 0;  ///< final damping
  std::string start;  ///< the start chosen
};

}  // namespace primo::motion
