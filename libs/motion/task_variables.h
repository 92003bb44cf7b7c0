// Task variables φ_i : q → R^m (paper, IV.A): one file each, task_NAME.cpp, and one line in the table of
// task_variables.cpp.
#pragma once

#include <Eigen/Core>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "core/result.h"
#include "motion/planning_scene.h"
#include "motion/primitive.h"
#include "robot/robot.h"

namespace primo::motion {

/// m × n, rows contiguous: gradients are added up row by row.
using Jacobian = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

/// What a task variable is built on. Robot and scene must outlive it.
struct TaskSetup {
  const robot::Robot& robot;
  const PlanningScene& scene;
  std::map<std::string, double> parameters = {};  ///< complete: defaults filled in
  std::map<std::string, std::string> of = {};     ///< complete: names of frames, objects and axes
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
  /// How many inequalities c(q) ≥ 0 the variable stands for where a solver keeps it as a hard constraint.
  virtual int inequalities() const { return 0; }
  /// Writes c and, unless J is null, ∂c/∂q (a row for each). Rows that are far from their bound are cut off at a
  /// constant, their gradient zero.
  virtual void inequality(const Configuration& /*configuration*/, Eigen::Ref<Eigen::VectorXd> /*c*/,
                          Jacobian* /*J*/) const {}
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

/// A name that a task may give: of a frame, of an object, or one of a few words.
struct NameSpec {
  std::string name;
  std::string value;                      ///< default
  std::vector<std::string> choices = {};  ///< empty: what find_frame() or find_object() know
  std::string help = {};
};

struct TaskVariableEntry {
  std::string name;  ///< what a task's `variable` says
  std::string help;
  std::vector<ParameterSpec> parameters;
  std::vector<NameSpec> of;
  /// Error: a frame or object that there is not, or a scene without what the variable needs.
  Result<std::unique_ptr<TaskVariable>> (*create)(const TaskSetup& setup);
  bool needs_map = false;  ///< whether it needs PlanningScene::perceive()
};

/// For entries whose variable takes nothing but the setup and cannot fail.
template <class T>
Result<std::unique_ptr<TaskVariable>> make_variable(const TaskSetup& setup) {
  return std::unique_ptr<TaskVariable>(std::make_unique<T>(setup));
}

/// All task variables.
const std::vector<TaskVariableEntry>& task_variables();

/// The entry of this name, or an Error that lists the names.
Result<const TaskVariableEntry*> find_task_variable(const std::string& name);

/// Parameters with defaults filled in. Error config: an unknown name, or a value out of bounds.
Result<std::map<std::string, double>> complete_parameters(const TaskVariableEntry& entry,
                                                          const std::map<std::string, double>& given);
/// Names with defaults filled in. Error config: an unknown key, or a word that is not one of the choices.
Result<std::map<std::string, std::string>> complete_names(const TaskVariableEntry& entry,
                                                          const std::map<std::string, std::string>& given);

/// The variable that a task names, with its parameters and names. Errors: as the functions above and create().
Result<std::unique_ptr<TaskVariable>> make_task_variable(const Task& task, const robot::Robot& robot,
                                                         const PlanningScene& scene);

/// Whether a task of the primitive needs the scene's octree.
bool needs_map(const Primitive& primitive);

TaskVariableEntry position_task();
TaskVariableEntry alignment_task();
TaskVariableEntry finger_distance_task();
TaskVariableEntry opposition_task();
TaskVariableEntry collision_task();
TaskVariableEntry limits_task();
TaskVariableEntry homing_task();
TaskVariableEntry orientation_task();
TaskVariableEntry frame_velocity_task();
TaskVariableEntry end_velocity_task();
TaskVariableEntry perceived_collision_task();

}  // namespace primo::motion
