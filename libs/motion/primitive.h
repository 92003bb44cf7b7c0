// A motion primitive P = (φ_i, y*_i,t, ρ_i,t): task variables with targets and precisions over time (paper, eq. 2).
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "config/config.h"

namespace primo::motion {

/// When a task variable counts, and the target y*_t there. Step t runs from 1 to T; `at` is a fraction of T, y* the
/// task's target. In brackets: the precision.
enum class Profile {
  constant,    ///< y* at every step [ρ]
  final,       ///< y* at T only [ρ]
  late,        ///< y* for t ≥ at·T [ρ]
  early_late,  ///< y* at every step [ρ before at·T, rho_late from there on]
  ramp,        ///< 0 before at·T, then linear to y* at T [as early_late]
  early,       ///< y* for t ≤ at·T [ρ]
  /// The first and last w = at·T steps, for velocities of a motion from rest to rest: y* t/w for t ≤ w, and
  /// −y* (T − t)/w for t ≥ T − w; nothing between [ρ]. at ≤ ½.
  ends,
};

/// How the optimizer goes over an entry. natural: precisions in log10, everything else as it is.
enum class Scale { natural, linear, log };
}  // namespace primo::motion

template <>
struct primo::config::EnumNames<primo::motion::Scale> {
  static constexpr std::array<std::string_view, 3> names = {"natural", "linear", "log"};
};
template <>
struct primo::config::EnumNames<primo::motion::Profile> {
  static constexpr std::array<std::string_view, 7> names = {"constant", "final", "late", "early_late",
                                                            "ramp",     "early", "ends"};
};

namespace primo::motion {

/// What the optimizer may do with one entry of a task.
struct Search {
  bool fixed = false;  ///< not open, though the task's precisions are
  Scale scale = Scale::natural;
  double min = 0, max = 0;  ///< of the entry itself; both 0: the study's bounds, for precisions only
  template <class V>
  void visit(V&& v) {
    v("fixed", fixed, {.help = "keeps its value"});
    v("scale", scale, {.help = "natural: log10 for precisions, else linear"});
    v("min", min, {.help = "of the entry itself, not of its logarithm", .min = -1e6, .max = 1e12});
    v("max", max, {.help = "min and max 0: the study's bounds, for precisions only", .min = -1e6, .max = 1e12});
  }
};

/// One φ_i with its target, time profile and precision(s). `variable` names an entry of the table of task variables.
struct Task {
  std::string name;      ///< unique in the primitive; what reports and ρ tables call it
  std::string variable;  ///< the φ: a key of task_variables()
  Profile profile = Profile::constant;
  double at = 0.8;                           ///< where a phase starts or ends, as a fraction of T
  double rho = 1.0;                          ///< ρ (early phase)
  double rho_late = 0.0;                     ///< ρ of the late phase; only for early_late and ramp
  std::vector<double> target;                ///< y*; empty: zero
  std::map<std::string, double> parameters;  ///< of the task variable, e.g. margin
  bool optimize = true;                      ///< whether its ρ is open to the optimizer
  /// Which frames and objects φ is of, e.g. {frame: held, object: second}; see find_frame() and find_object().
  std::map<std::string, std::string> of = {};
  /// Whether the target comes linearly from φ(q_0): y*_t = y* + (1 − t/T) (φ(q_0) − y*). Not for ramp and ends, whose
  /// targets have a course of their own.
  bool from_start = false;
  /// How entries are searched: rho, rho_late, at, target.0, target.1, … What is named here is open, whatever `optimize`
  /// says, unless it is fixed.
  std::map<std::string, Search> search = {};
  template <class V>
  void visit(V&& v) {
    v("name", name, {.help = "unique in the primitive", .required = true});
    v("variable", variable, {.help = "the task variable φ", .required = true});
    v("profile", profile, {.help = "when it counts"});
    v("at", at, {.help = "where a phase starts or ends, fraction of T", .min = 0, .max = 1});
    v("rho", rho, {.help = "precision ρ", .min = 0, .max = 1e12});
    v("rho_late", rho_late, {.help = "precision of the late phase", .min = 0, .max = 1e12});
    v("target", target, {.help = "y*"});
    v("parameters", parameters, {.help = "of the task variable"});
    v("optimize", optimize, {.help = "open to the optimizer"});
    v("of", of, {.help = "the frames and objects φ is of"});
    v("from_start", from_start, {.help = "the target comes linearly from its value at the start"});
    v("search", search, {.help = "bounds and scale of what is open: rho, rho_late, at, target.0, target.1, ..."});
  }
};

/// A coordinate of the optimizer's search space.
struct OpenEntry {
  std::string name;  ///< "position", "fingers.early", "position.at", "lift.target.2"
  bool log = false;  ///< whether the coordinate is log10 of the entry
  double value = 0;  ///< the coordinate of the primitive's own entry
  double lower = 0, upper = 0;
};

struct Primitive {
  std::string name;
  std::string action;     ///< the symbolic action it realises, e.g. grasp
  int steps = 64;         ///< T
  double duration = 4.0;  ///< s
  std::string solver = "gauss_newton";
  std::string start = "ik";  ///< an entry of starts()
  int max_iterations = 100;
  double tolerance = 1e-2;    ///< on the step, rad
  double control_rate = 1.0;  ///< H = control_rate · W · τ
  std::vector<Task> tasks;

  /// What the optimizer may change, in the order of tasks; in a task: precision (early before late), profile fraction,
  /// targets. `log_rho_min` and `log_rho_max` bound precisions that have no bounds of their own.
  std::vector<OpenEntry> open_entries(double log_rho_min, double log_rho_max) const;
  /// The primitive with these coordinates. @pre one for each open entry.
  Primitive with_entries(const std::vector<double>& coordinates) const;

  /// The open precisions alone, as log10 ρ, in the same order; and their names.
  std::vector<double> log_rho() const;
  std::vector<std::string> rho_names() const;
  /// The primitive with these log10 ρ. @pre size matches log_rho().
  Primitive with_log_rho(const std::vector<double>& values) const;
  Status validate() const;
  template <class V>
  void visit(V&& v) {
    v("name", name, {.required = true});
    v("action", action, {.help = "the symbolic action", .required = true});
    v("steps", steps, {.help = "T", .min = 1, .max = 1000});
    v("duration", duration, {.unit = "s", .min = 0.05, .max = 60});
    v("solver", solver, {.help = "the planner"});
    v("start", start, {.help = "what the planner starts from", .choices = {"rest", "ik", "last", "best"}});
    v("max_iterations", max_iterations, {.min = 1, .max = 10000});
    v("tolerance", tolerance, {.help = "on the step", .unit = "rad", .min = 1e-12, .max = 1});
    v("control_rate", control_rate, {.help = "scales the joints' control weights", .min = 1e-9, .max = 1e9});
    v("tasks", tasks, {.required = true});
  }
};

/// Reads and validates a primitive file.
Result<Primitive> read_primitive(const std::filesystem::path& path);

}  // namespace primo::motion
