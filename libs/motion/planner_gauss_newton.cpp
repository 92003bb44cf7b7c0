#include "motion/planner_gauss_newton.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "motion/motion_cost.h"
#include "motion/start.h"

namespace primo::motion {
namespace {

constexpr int kInverseKinematicsIterations = 60;

Plan bad_input(const std::string& reason) {
  Plan plan;
  plan.status = PlanStatus::bad_input;
  plan.reason = reason;
  return plan;
}

std::string number(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.3g", value);
  return text;
}

Result<Eigen::VectorXd> checked_start(const robot::Robot& robot, const std::vector<double>& q_start) {
  if (static_cast<int>(q_start.size()) != robot.joints()) {
    return Error{Code::data, "q_start has " + std::to_string(q_start.size()) + " entries, expected " +
                                 std::to_string(robot.joints()) + " as robot '" + robot.name() + "' has joints"};
  }
  for (std::size_t i = 0; i < q_start.size(); ++i) {
    if (!(std::abs(q_start[i]) <= 100)) {
      return Error{Code::data, "q_start of joint '" + robot.joint_names()[i] + "' is " + number(q_start[i]) +
                                   ", expected a finite angle below 100 rad"};
    }
  }
  return Eigen::VectorXd(Eigen::Map<const Eigen::VectorXd>(q_start.data(), static_cast<Eigen::Index>(q_start.size())));
}

TrajectoryProblem make_problem(const robot::Robot& robot, const Primitive& primitive, const Eigen::VectorXd& q_start) {
  TrajectoryProblem problem;
  problem.steps = primitive.steps;
  problem.dt = primitive.duration / primitive.steps;
  problem.H = problem.dt * primitive.control_rate * robot.control_weights();
  problem.q_start = q_start;
  problem.v_start = Eigen::VectorXd::Zero(q_start.size());
  return problem;
}

std::string why_stopped(const Solution& solution, const Primitive& primitive) {
  const std::string after = " after " + std::to_string(solution.iterations) + " steps";
  switch (solution.status) {
    case PlanStatus::converged_step:
      return "converged" + after + ": the last changed no angle by more than " + number(solution.last_step) + " rad";
    case PlanStatus::converged_cost:
      return "converged" + after + ": the cost no longer falls";
    case PlanStatus::iteration_limit:
      return "stopped at the limit of " + std::to_string(primitive.max_iterations) + " iterations (last step " +
             number(solution.last_step) + " rad, tolerance " + number(primitive.tolerance) + " rad)";
    case PlanStatus::damping_limit:
      return "stopped" + after + ": no step at the largest damping lowers the cost";
    case PlanStatus::factorisation_failed:
      return "stopped" + after + ": the Gauss–Newton system cannot be factorised at the largest damping";
    case PlanStatus::bad_input:
      return "the cost at the start is not finite";
  }
  return "";
}

std::string reason(const Solution& solution, const Primitive& primitive, const Plan& plan, MotionCost& cost) {
  std::string text = why_stopped(solution, primitive);
  const auto worst = std::max_element(plan.cost_tasks.begin(), plan.cost_tasks.end(),
                                      [](const TaskCost& a, const TaskCost& b) { return a.cost < b.cost; });
  if (worst == plan.cost_tasks.end() || !(worst->cost > 0)) return text;
  const auto index = static_cast<std::size_t>(worst - plan.cost_tasks.begin());
  return text + "; '" + worst->task + "' costs most (" + number(worst->cost) + " of " + number(plan.cost_final) +
         "), " + cost.explain(index, solution.q);
}

Trajectory make_trajectory(const robot::Robot& robot, const TrajectoryProblem& problem, const Eigen::MatrixXd& q) {
  Trajectory trajectory;
  trajectory.joints = robot.joint_names();
  trajectory.dt = problem.dt;
  trajectory.q.resize(problem.steps + 1, problem.joints());
  trajectory.q.row(0) = problem.q_start.transpose();
  trajectory.q.bottomRows(problem.steps) = q.transpose();
  return trajectory;
}

}  // namespace

Plan GaussNewtonPlanner::plan(const robot::Robot& robot, const PlanRequest& request) const {
  const Primitive& primitive = request.primitive;
  if (auto status = primitive.validate(); !status.ok()) return bad_input(status.error().message);
  auto q_start = checked_start(robot, request.q_start);
  if (!q_start.ok()) return bad_input(q_start.error().message);
  auto scene = PlanningScene::create(request.scene, request.action);
  if (!scene.ok()) return bad_input(scene.error().message);
  auto created = MotionCost::create(robot, *scene, primitive, *q_start);
  if (!created.ok()) return bad_input(created.error().message);
  MotionCost& cost = **created;

  const TrajectoryProblem problem = make_problem(robot, primitive, *q_start);
  SolverOptions options;
  options.max_iterations = primitive.max_iterations;
  options.step_tolerance = primitive.tolerance;
  Plan plan;
  plan.start = primitive.start;
  Eigen::MatrixXd start = primitive.start == "ik"
                              ? minimum_jerk(problem, inverse_kinematics(problem, cost, kInverseKinematicsIterations))
                              : rest_start(problem);
  Solution solution = gauss_newton(problem, cost, std::move(start), options);
  plan.status = solution.status;
  plan.iterations = solution.iterations;
  plan.rejected = solution.rejected;
  plan.evaluations = solution.evaluations;
  plan.cost_initial = solution.cost_initial;
  plan.cost_final = solution.cost;
  plan.cost_control = solution.cost_control;
  plan.gradient_norm = solution.gradient_norm;
  plan.lambda = solution.lambda;
  if (plan.status == PlanStatus::bad_input) {
    plan.reason = why_stopped(solution, primitive);
    return plan;
  }
  plan.cost_tasks = cost.task_costs(solution.q);
  plan.reason = reason(solution, primitive, plan, cost);
  plan.trajectory = make_trajectory(robot, problem, solution.q);
  if (request.want_gains) plan.gains = riccati_gains(problem, solution.q, solution.R);
  return plan;
}

}  // namespace primo::motion
