#include "motion/task_variables.h"

#include <algorithm>

#include "config/config.h"

namespace primo::motion {

const std::vector<TaskVariableEntry>& task_variables() {
  static const std::vector<TaskVariableEntry> table = {
      position_task(),  alignment_task(), finger_distance_task(), opposition_task(),
      collision_task(), limits_task(),    homing_task(),
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

}  // namespace primo::motion
