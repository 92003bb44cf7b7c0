#include "motion/primitive.h"

#include <algorithm>
#include <cmath>
#include <set>

#include "core/check.h"
#include "motion/planner.h"
#include "motion/start.h"
#include "motion/task_variables.h"

namespace primo::motion {
namespace {

bool two_phased(const Task& task) { return task.profile == Profile::early_late || task.profile == Profile::ramp; }

/// Calls f(name, ρ) for each open precision, in order.
template <class P, class F>
void for_each_open(P& primitive, F&& f) {
  for (auto& task : primitive.tasks) {
    if (!task.optimize) continue;
    if (two_phased(task)) {
      f(task.name + ".early", task.rho);
      f(task.name + ".late", task.rho_late);
    } else {
      f(task.name, task.rho);
    }
  }
}

Error refuse(const Primitive& primitive, const std::string& message) {
  return {Code::config, "primitive '" + primitive.name + "': " + message};
}

Status validate_task(const Primitive& primitive, std::size_t i) {
  const Task& task = primitive.tasks[i];
  const std::string key = "tasks[" + std::to_string(i) + "] '" + task.name + "'";
  if (task.name.empty()) return refuse(primitive, key + ": name must not be empty");
  auto entry = find_task_variable(task.variable);
  if (!entry.ok()) return refuse(primitive, key + ".variable: " + entry.error().message);
  if (auto parameters = complete_parameters(**entry, task.parameters); !parameters.ok()) {
    return refuse(primitive, key + ".parameters: " + parameters.error().message);
  }
  if (auto names = complete_names(**entry, task.of); !names.ok()) {
    return refuse(primitive, key + ".of: " + names.error().message);
  }
  const auto good = [](double rho) { return std::isfinite(rho) && rho >= 0 && rho <= 1e12; };
  if (!good(task.rho) || !good(task.rho_late)) {
    return refuse(primitive, key + ": precisions must be in 0 … 1e12");
  }
  if (!two_phased(task) && task.rho_late != 0) {
    return refuse(primitive, key + ".rho_late: only profiles early_late and ramp have a late precision");
  }
  if (task.optimize && (task.rho <= 0 || (two_phased(task) && task.rho_late <= 0))) {
    return refuse(primitive, key + ": a precision of 0 has no logarithm; make it positive or set optimize: false");
  }
  if (!(task.at >= 0 && task.at <= 1)) return refuse(primitive, key + ".at: expected 0 … 1");
  if (task.profile == Profile::ends && task.at > 0.5) {
    return refuse(primitive, key + ".at: profile ends needs 0 … 0.5, or its two ends overlap");
  }
  if (task.from_start && (task.profile == Profile::ramp || task.profile == Profile::ends)) {
    return refuse(primitive, key + ".from_start: the target of profiles ramp and ends has a course of its own");
  }
  for (const double y : task.target) {
    if (!(std::abs(y) < 1e6)) return refuse(primitive, key + ".target: expected finite numbers below 1e6");
  }
  return success();
}

}  // namespace

std::vector<double> Primitive::log_rho() const {
  std::vector<double> values;
  for_each_open(*this, [&](const std::string&, const double& rho) { values.push_back(std::log10(rho)); });
  return values;
}

std::vector<std::string> Primitive::rho_names() const {
  std::vector<std::string> names;
  for_each_open(*this, [&](const std::string& rho_name, const double&) { names.push_back(rho_name); });
  return names;
}

Primitive Primitive::with_log_rho(const std::vector<double>& values) const {
  Primitive changed = *this;
  std::size_t i = 0;
  for_each_open(changed, [&](const std::string&, double& rho) {
    PRIMO_CHECK(i < values.size(), "fewer log ρ than open precisions");
    rho = std::pow(10.0, values[i++]);
  });
  PRIMO_CHECK(i == values.size(), "more log ρ than open precisions");
  return changed;
}

Status Primitive::validate() const {
  if (steps < 1 || steps > 1000) return refuse(*this, "steps: expected 1 … 1000");
  if (!(duration >= 0.05 && duration <= 60)) return refuse(*this, "duration: expected 0.05 … 60 s");
  if (max_iterations < 1) return refuse(*this, "max_iterations: expected at least 1");
  if (!(tolerance >= 1e-12 && tolerance <= 1)) return refuse(*this, "tolerance: expected 1e-12 … 1 rad");
  if (!(control_rate >= 1e-9 && control_rate <= 1e9)) return refuse(*this, "control_rate: expected 1e-9 … 1e9");
  std::string known;
  for (const auto& entry : starts()) known += (known.empty() ? "" : ", ") + entry.name;
  if (std::none_of(starts().begin(), starts().end(), [&](const auto& entry) { return entry.name == start; })) {
    return refuse(*this, "start: '" + start + "', expected one of " + known);
  }
  std::string solvers;
  for (const auto& entry : planners()) solvers += (solvers.empty() ? "" : ", ") + entry.name;
  if (std::none_of(planners().begin(), planners().end(), [&](const auto& entry) { return entry.name == solver; })) {
    return refuse(*this, "solver: no planner '" + solver + "'; there are " + solvers);
  }
  if (tasks.empty()) return refuse(*this, "tasks: at least one is needed");
  std::set<std::string> names;
  for (std::size_t i = 0; i < tasks.size(); ++i) {
    PRIMO_TRY(validate_task(*this, i));
    if (!names.insert(tasks[i].name).second) return refuse(*this, "tasks: '" + tasks[i].name + "' is there twice");
  }
  return success();
}

Result<Primitive> read_primitive(const std::filesystem::path& path) { return config::read<Primitive>(path); }

}  // namespace primo::motion
