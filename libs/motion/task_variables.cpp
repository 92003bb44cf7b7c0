#include "motion/task_variables.h"

#include <algorithm>

#include "config/config.h"

namespace primo::motion {

const std::vector<TaskVariableEntry>& task_variables() {
  static const std::vector<TaskVariableEntry> table = {
      position_task(),     alignment_task(),           finger_distance_task(),
      opposition_task(),   collision_task(),           limits_task(),
      homing_task(),       orientation_task(),         frame_velocity_task(),
      end_velocity_task(), perceived_collision_task(),
  };
  return table;
}

Result<const TaskVariableEntry*> find_task_variable(const std::string& name) {
  std::string known;
  for (const auto& entry : task_variables()) {
    if (entry.name == name) return &entry;
    known += (known.empty() ? "" : ", ") + entry.name;
  }
  return Error{Code::config, "no task variable '" + name + "'; there are " + known};
}

Result<std::map<std::string, double>> complete_parameters(const TaskVariableEntry& entry,
                                                          const std::map<std::string, double>& given) {
  std::map<std::string, double> complete;
  std::string known;
  for (const auto& spec : entry.parameters) {
    complete[spec.name] = spec.value;
    known += (known.empty() ? "" : ", ") + spec.name;
  }
  for (const auto& [name, value] : given) {
    const auto spec = std::find_if(entry.parameters.begin(), entry.parameters.end(),
                                   [&, &key = name](const ParameterSpec& candidate) { return candidate.name == key; });
    if (spec == entry.parameters.end()) {
      return Error{Code::config, "task variable '" + entry.name + "' has no parameter '" + name + "'; it has " +
                                     (known.empty() ? "none" : known)};
    }
    if (!(value >= spec->min && value <= spec->max)) {
      return Error{Code::config, "parameter '" + name + "' of task variable '" + entry.name + "' is " +
                                     config::detail::format(value) + ", expected " + config::detail::format(spec->min) +
                                     " … " + config::detail::format(spec->max)};
    }
    complete[name] = value;
  }
  return complete;
}

Result<std::map<std::string, std::string>> complete_names(const TaskVariableEntry& entry,
                                                          const std::map<std::string, std::string>& given) {
  std::map<std::string, std::string> complete;
  std::string known;
  for (const auto& spec : entry.of) {
    complete[spec.name] = spec.value;
    known += (known.empty() ? "" : ", ") + spec.name;
  }
  for (const auto& [name, value] : given) {
    const auto spec = std::find_if(entry.of.begin(), entry.of.end(),
                                   [&, &key = name](const NameSpec& candidate) { return candidate.name == key; });
    if (spec == entry.of.end()) {
      return Error{Code::config, "task variable '" + entry.name + "' takes no '" + name + "'; it takes " +
                                     (known.empty() ? "none" : known)};
    }
    const auto& choices = spec->choices;
    if (value.empty() || (!choices.empty() && std::find(choices.begin(), choices.end(), value) == choices.end())) {
      return Error{Code::config, "'" + name + "' of task variable '" + entry.name + "' is '" + value + "', expected " +
                                     (choices.empty() ? spec->help : "one of " + config::detail::joined(choices))};
    }
    complete[name] = value;
  }
  return complete;
}

Result<std::unique_ptr<TaskVariable>> make_task_variable(const Task& task, const robot::Robot& robot,
                                                         const PlanningScene& scene) {
  PRIMO_ASSIGN(const auto* entry, find_task_variable(task.variable));
  TaskSetup setup{robot, scene};
  PRIMO_ASSIGN(setup.parameters, complete_parameters(*entry, task.parameters));
  PRIMO_ASSIGN(setup.of, complete_names(*entry, task.of));
  return entry->create(setup);
}

bool needs_map(const Primitive& primitive) {
  return std::any_of(primitive.tasks.begin(), primitive.tasks.end(), [](const Task& task) {
    const auto entry = find_task_variable(task.variable);
    return entry.ok() && (*entry)->needs_map;
  });
}

}  // namespace primo::motion
