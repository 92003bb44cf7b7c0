// The trajectory problem by the interior-point method Ipopt (Wächter and Biegler, 2006): the reference that the other
// solvers are held to, and the only one that keeps hard limits and clearances.
#include <algorithm>
#include <cmath>
#include <coin/IpIpoptApplication.hpp>
#include <mutex>
#include <utility>

#include "motion/ipopt_program.h"

namespace primo::motion {
namespace {

using Ipopt::SmartPtr;

constexpr int kRounds = 8;  // of adding to the working set and of lowering the barrier
const double kPush =
    getenv("PUSH") ? atof(getenv("PUSH")) : 1e-3;  // rad, m: how far inside its bounds the start is moved

/// MUMPS keeps global state: two threads in it crash. Processes do not share it.
std::mutex& mumps() {
  static std::mutex mutex;
  return mutex;
}

SmartPtr<Ipopt::IpoptApplication> make_application(double barrier) {
  SmartPtr<Ipopt::IpoptApplication> application = new Ipopt::IpoptApplication(false);
  auto& options = *application->Options();
  options.SetIntegerValue("print_level", 0);
  options.SetStringValue("sb", "yes");
  options.SetStringValue("nlp_scaling_method", "none");  // IpoptProgram scales
  options.SetIntegerValue("mumps_pivot_order", 0);       // AMD: the default ordering takes three times as long
  // A tenth less time: the matrix needs neither permuting nor scaling, and its solutions no verification.
  options.SetIntegerValue("mumps_permuting_scaling", 0);
  options.SetIntegerValue("mumps_scaling", 0);
  options.SetStringValue("fast_step_computation", "yes");
  options.SetIntegerValue("max_iter", 1000000);  // IpoptProgram counts
  options.SetNumericValue("tol", 1e-9);
  options.SetIntegerValue("acceptable_iter", 0);
  options.SetIntegerValue("watchdog_shortened_iter_trigger", 0);  // the watchdog lets the cost rise
  options.SetNumericValue("bound_relax_factor", 0);
  options.SetNumericValue("mu_init", barrier);
  options.SetStringValue("bound_mult_init_method", "mu-based");
  for (const char* push : {"bound_push", "bound_frac", "slack_bound_push", "slack_bound_frac"})
    options.SetNumericValue(push, kPush);
  if (getenv("IPO")) {
    std::string s = getenv("IPO");
    size_t p = 0;
    while (p < s.size()) {
      size_t e = s.find(',', p);
      if (e == std::string::npos) e = s.size();
      std::string kv = s.substr(p, e - p);
      size_t q = kv.find('=');
      std::string k = kv.substr(0, q), v = kv.substr(q + 1);
      bool ok = false;
      if (!ok) ok = options.SetIntegerValue(k, atoi(v.c_str()));
      if (!ok) ok = options.SetNumericValue(k, atof(v.c_str()));
      if (!ok) ok = options.SetStringValue(k, v);
      if (!ok) printf("bad %s\n", kv.c_str());
      p = e + 1;
    }
  }
  // No file of options: a plan depends on nothing but its request.
  if (application->Initialize("") != Ipopt::Solve_Succeeded) return nullptr;
  return application;
}

PlanStatus status_of(Ipopt::ApplicationReturnStatus returned, const IpoptProgram& program, const BestPath& best) {
  if (program.stopped()) return program.status();
  switch (returned) {
    case Ipopt::Solve_Succeeded:
    case Ipopt::Solved_To_Acceptable_Level:
    case Ipopt::Search_Direction_Becomes_Too_Small:
    case Ipopt::Feasible_Point_Found:
      return PlanStatus::converged_cost;
    case Ipopt::Maximum_Iterations_Exceeded:
    case Ipopt::Maximum_CpuTime_Exceeded:
    case Ipopt::User_Requested_Stop:
      return PlanStatus::iteration_limit;
    case Ipopt::Infeasible_Problem_Detected:
      return PlanStatus::infeasible;
    case Ipopt::Restoration_Failed:
      return best.violation > kFeasible ? PlanStatus::infeasible : PlanStatus::damping_limit;
    default:
      return PlanStatus::factorisation_failed;
  }
}

/// Whether the limits of every joint are in order, so that there is a path between them.
bool in_order(const TrajectoryProblem& problem) { return (problem.q_lower.array() <= problem.q_upper.array()).all(); }

bool all_fixed(const TrajectoryProblem& problem) {
  return problem.q_lower.size() > 0 && (problem.q_lower.array() == problem.q_upper.array()).all();
}

class Solver {
 public:
  Solver(const TrajectoryProblem& problem, StageCosts& stages, const SolverOptions& options)
      : problem_(problem), stages_(stages), options_(options) {}

  Solution solve(Eigen::MatrixXd q, bool constrained);

 private:
  double barrier(const HardConstraints& constraints) const;
  PlanStatus run(const HardConstraints& constraints);
  PlanStatus unconstrained() { return run({}); }
  PlanStatus within_constraints();
  bool add_rows(std::vector<std::vector<int>>& rows);
  bool clamp(Eigen::MatrixXd& q) const;

  const TrajectoryProblem& problem_;
  StageCosts& stages_;
  const SolverOptions& options_;
  PathModel start_;  // of the next run
  BestPath best_;
  Usage usage_;
};

/// The barrier μ Σ log that moves the minimum's cost by no more than the tolerance: the duality gap is μ times the
/// number of logarithms.
double Solver::barrier(const HardConstraints& constraints) const {
  const int terms = std::max(1, barrier_terms(problem_, constraints));
  const double gap = std::max(options_.cost_tolerance, 1e-8) * cost_scale(problem_) * best_.cost;
  return std::clamp(gap / terms, 1e-11, 0.1);
}

/// One run of Ipopt from start_.
PlanStatus Solver::run(const HardConstraints& constraints) {
  const auto application = make_application(barrier(constraints));
  if (!Ipopt::IsValid(application)) return PlanStatus::factorisation_failed;
  const SmartPtr<IpoptProgram> program =
      new IpoptProgram(problem_, stages_, options_, constraints, start_, best_, usage_);
  const auto returned = application->OptimizeTNLP(Ipopt::GetRawPtr(program));
  return status_of(returned, *program, best_);
}

/// Takes up the inequalities that have a gradient on the path to start from. False when there is none but those taken
/// up before.
bool Solver::add_rows(std::vector<std::vector<int>>& rows) {
  bool added = false;
  Eigen::VectorXd c(stages_.inequalities());
  Eigen::MatrixXd J(stages_.inequalities(), problem_.joints());
  for (int t = 1; t <= problem_.steps; ++t) {
    stages_.inequality(t, start_.q.col(t - 1), c, &J);
    auto& taken = rows[t - 1];
    for (int row = 0; row < c.size(); ++row) {
      if (J.row(row).isZero(0) || std::find(taken.begin(), taken.end(), row) != taken.end()) continue;
      taken.push_back(row);
      added = true;
    }
  }
  return added;
}

/// Only the inequalities near their bounds enter the program. Where its solution violates others, they are taken up and
/// Ipopt goes on from there; so it does where the cost has fallen so far that the barrier is too high.
PlanStatus Solver::within_constraints() {
  HardConstraints constraints{problem_.q_lower.size() > 0, {}};
  const bool inequalities = stages_.inequalities() > 0;
  if (inequalities) constraints.rows.resize(problem_.steps);
  PlanStatus status = PlanStatus::iteration_limit;
  for (int round = 0; round < kRounds; ++round) {
    const bool added = inequalities && add_rows(constraints.rows);
    const double low = barrier(constraints);
    status = run(constraints);
    if (usage_.trials >= options_.max_iterations) break;
    const bool clear = best_.violation <= kFeasible || (round > 0 && !added);
    if (clear && barrier(constraints) > 0.2 * low) break;
    start_.q = best_.q;
    if (!evaluate(problem_, stages_, start_, std::numeric_limits<double>::max())) break;
  }
  const bool converged = status == PlanStatus::converged_cost || status == PlanStatus::converged_step;
  return converged && best_.violation > kFeasible ? PlanStatus::infeasible : status;
}

bool Solver::clamp(Eigen::MatrixXd& q) const {
  if (problem_.q_lower.size() == 0) return true;
  if (!in_order(problem_) || !q.allFinite()) return false;
  for (Eigen::Index t = 0; t < q.cols(); ++t) q.col(t) = q.col(t).cwiseMax(problem_.q_lower).cwiseMin(problem_.q_upper);
  return true;
}

Solution Solver::solve(Eigen::MatrixXd q, bool constrained) {
  Solution solution;
  start_.q = std::move(q);
  const bool finite = (!constrained || clamp(start_.q)) && begin(problem_, stages_, start_, solution);
  if (!finite) {
    finish(problem_, std::move(start_), false, solution);
    return solution;
  }
  usage_.lambda = options_.lambda_initial;
  std::vector<Eigen::VectorXd> c;
  best_ = {start_.q, start_.cost, constrained ? violation(problem_, stages_, start_.q, c) : 0};
  if (constrained && all_fixed(problem_)) {
    solution.status = PlanStatus::converged_step;
  } else {
    try {
      const std::lock_guard lock(mumps());
      solution.status = constrained ? within_constraints() : unconstrained();
    } catch (...) {  // Ipopt's exceptions are not derived from std::exception
      solution.status = PlanStatus::factorisation_failed;
    }
  }
  start_.q = best_.q;
  solution.iterations = usage_.iterations;
  solution.rejected = std::max(0, usage_.trials - usage_.iterations);
  solution.evaluations += usage_.evaluations + 1;
  solution.last_step = usage_.last_step;
  solution.lambda = usage_.lambda;
  finish(problem_, std::move(start_), evaluate(problem_, stages_, start_, std::numeric_limits<double>::max()),
         solution);
  return solution;
}

}  // namespace

Solution ipopt(const TrajectoryProblem& problem, StageCosts& stages, Eigen::MatrixXd q, const SolverOptions& options) {
  return Solver(problem, stages, options).solve(std::move(q), false);
}

Solution ipopt_constrained(const TrajectoryProblem& problem, StageCosts& stages, Eigen::MatrixXd q,
                           const SolverOptions& options) {
  return Solver(problem, stages, options).solve(std::move(q), true);
}

}  // namespace primo::motion
