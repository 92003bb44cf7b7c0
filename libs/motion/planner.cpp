#include "motion/planner.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <optional>

#include "motion/motion_cost.h"
#include "motion/start.h"
#include "motion/task_variables.h"
#include "motion/trajectory_problem.h"

namespace primo::motion {
namespace {

constexpr double kCostTolerance = 3e-3;  // starts differ by thirty times more than what lies below it

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
  problem.q_lower = robot.lower();
  problem.q_upper = robot.upper();
  problem.arm_joints = robot.arm_joints();
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
    case PlanStatus::infeasible:
      return "stopped" + after + ": no path nearby keeps the limits and clearances";
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

Plan make_plan(const robot::Robot& robot, const PlanRequest& request, const TrajectoryProblem& problem,
               const Solution& solution, MotionCost& cost) {
  const Primitive& primitive = request.primitive;
  Plan plan;
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
  if (request.want_gains) plan.gains = riccati_gains(problem, solution.q, solution.models);
  return plan;
}

Result<const PlannerEntry*> find_planner(const std::string& name) {
  std::string known;
  for (const auto& entry : planners()) {
    if (entry.name == name) return &entry;
    known += (known.empty() ? "" : ", ") + entry.name;
  }
  return Error{Code::data, "solver: no planner '" + name + "'; there are " + known};
}

Result<Plan> try_plan(const robot::Robot& robot, const PlanRequest& request) {
  const Primitive& primitive = request.primitive;
  PRIMO_ASSIGN(const auto* planner, find_planner(primitive.solver));
  PRIMO_TRY(primitive.validate());
  PRIMO_ASSIGN(const auto q_start, checked_start(robot, request.q_start));
  PRIMO_ASSIGN(auto scene, PlanningScene::create(request.scene, request.action, request.held));
  if (needs_map(primitive)) PRIMO_TRY(scene.perceive(request.scene));
  PRIMO_ASSIGN(const auto cost, MotionCost::create(robot, scene, primitive, q_start));
  const TrajectoryProblem problem = make_problem(robot, primitive, q_start);
  PRIMO_ASSIGN(auto starts, make_starts(problem, *cost, primitive.start, request.last));
  SolverOptions options;
  options.max_iterations = primitive.max_iterations;
  options.step_tolerance = primitive.tolerance;
  // Near a minimum the cost is quadratic in the step.
  options.cost_tolerance = std::min(kCostTolerance, 30 * primitive.tolerance * primitive.tolerance);
  std::optional<Solution> best;
  std::string chosen;
  for (auto& start : starts) {
    Solution solution = planner->solve(problem, *cost, std::move(start.q), options);
    const bool usable = solution.status != PlanStatus::bad_input;
    if (best && !(usable && (best->status == PlanStatus::bad_input || solution.cost < best->cost))) continue;
    best = std::move(solution);
    chosen = start.name;
  }
  Plan plan = make_plan(robot, request, problem, *best, *cost);
  plan.start = chosen;
  return plan;
}

}  // namespace

const std::vector<PlannerEntry>& planners() {
  static const std::vector<PlannerEntry> table = {
      {"gauss_newton", "Levenberg–Marquardt on the banded Gauss–Newton system", gauss_newton},
      {"aico", "approximate inference control", aico},
      {"aico_forward", "the same, linearising on the forward pass only", aico_forward},
      {"aico_symmetric", "the same, linearising on both passes", aico_symmetric},
      {"aico_local", "the same, linearising on both passes up to five times a step", aico_local},
      {"ilqg", "iterative LQG: a regularised Riccati sweep and a line search each step", ilqg},
      {"ipopt", "the interior-point method Ipopt, unconstrained", ipopt},
      {"ipopt_constrained", "Ipopt with joint limits and clearances as hard constraints", ipopt_constrained},
  };
  return table;
}

Plan plan(const robot::Robot& robot, const PlanRequest& request) {
  auto planned = try_plan(robot, request);
  return planned.ok() ? std::move(planned).value() : bad_input(planned.error().message);
}

}  // namespace primo::motion
