// Task variables φ_i : q → R^m (paper, II.B): one file each, task_NAME.cpp, and one line in the table of
// task_variables.cpp.
#pragma once

#include <Eigen/Core>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "core/result.h"
#include "motion/planning_scene.h"
#include "robot/robot.h"

namespace primo::motion {

/// m × n, rows contiguous: gradients are added up row by row.
using Jacobian = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

/// What a task variable is built on. Robot and scene must outlive it.
struct TaskSetup {
  const robot::Robot& robot;
  const PlanningScene& scene;
  std::map<std::string, double> parameters;  ///< complete: defaults filled in
};

/// A configuration and how it was come to, with its kinematics, at a phase t/T of the motion.
struct Configuration {
  const Eigen::VectorXd& q;             ///< q_t, rad
  const robot::Kinematics& kinematics;  ///< at q
  double phase = 0;                     ///< t/T in (0, 1]
  const Eigen::VectorXd& v;             ///< v_t = (q_t − q_{t−1}) / τ, rad/s
  double dt = 0;                        ///< τ, s
};

/// φ with its Jacobian. Immutable after construction.
class TaskVariable {
 public:
  virtual ~TaskVariable() = default;
  /// m, the number of rows.
  virtual int size() const = 0;
  /// Writes φ (m) and, unless J is null, ∂φ/∂q at constant v (m × n) into *J. Finite for every finite q and v.
  virtual void evaluate(const Configuration& configuration, Eigen::Ref<Eigen::VectorXd> phi, Jacobian* J) const = 0;
  /// Whether φ depends on v.
  virtual bool moving() const { return false; }
  /// Writes ∂φ/∂v (m × n) where φ depends on v.
  virtual void velocity_jacobian(const Configuration& /*configuration*/, Jacobian& /*J_v*/) const {}
  /// Whether a row counts at this phase, beside the task's time profile.
  virtual bool counts(int /*row*/, double /*phase*/) const { return true; }
  /// Whether the target is approached linearly from φ(q_0) over the motion, for a start that already violates it.
  virtual bool departs_from_start() const { return false; }
  /// Whether φ(q) = q, so that the solver can skip the Jacobian.
  virtual bool is_identity() const { return false; }
  /// What the value comes from, for a plan's reason: e.g. the pair of bodies in collision. Empty where there is nothing
  /// to say.
  virtual std::string explain(const Configuration& /*configuration*/) const { return {}; }
};

struct ParameterSpec {
  std::string name;
  double value = 0;  ///< default
  double min = 0, max = 0;
  std::string help;
};

struct TaskVariableEntry {
  std::string name;  ///< what a task's `variable` says
  std::string help;
  std::vector<ParameterSpec> parameters;
  std::unique_ptr<TaskVariable> (*create)(const TaskSetup& setup);
};

/// All task variables.
const std::vector<TaskVariableEntry>& task_variables();

/// The entry of this name, or an Error that lists the names.
Result<const TaskVariableEntry*> find_task_variable(const std::string& name);

/// Parameters with defaults filled in. Error config: an unknown name, or a value out of bounds.
Result<std::map<std::string, double>> complete_parameters(const TaskVariableEntry& entry,
                                                          const std::map<std::string, double>& given);

TaskVariableEntry position_task();
TaskVariableEntry alignment_task();
TaskVariableEntry finger_distance_task();
TaskVariableEntry opposition_task();
TaskVariableEntry collision_task();
TaskVariableEntry limits_task();
TaskVariableEntry homing_task();

}  // namespace primo::motion
