#include "motion/primitive.h"

#include <algorithm>
#include <cmath>
#include <set>
#include <type_traits>
#include <utility>

#include "core/check.h"
#include "motion/planner.h"
#include "motion/start.h"
#include "motion/task_variables.h"

namespace primo::motion {
namespace {

bool two_phased(const Task& task) { return task.profile == Profile::early_late || task.profile == Profile::ramp; }

bool has_fraction(const Task& task) { return task.profile != Profile::constant && task.profile != Profile::final; }

/// An entry of a task that may be open. `search` is null where the primitive file says nothing of it.
template <class T>
struct Entry {
  std::string key;   // in Task::search
  std::string name;  // in reports
  T* value;
  bool precision;
  const Search* search;
  bool open;
  bool log() const {
    const Scale scale = search == nullptr ? Scale::natural : search->scale;
    return scale == Scale::log || (scale == Scale::natural && precision);
  }
};

/// Calls f(entry) for each entry that this task has, in order.
template <class T, class F>
void for_each_entry(T& task, F&& f) {
  using Value = std::conditional_t<std::is_const_v<T>, const double, double>;
  const auto visit = [&](std::string key, const std::string& suffix, Value& value, bool precision) {
    const auto at = task.search.find(key);
    const Search* search = at == task.search.end() ? nullptr : &at->second;
    const bool open = search != nullptr ? !search->fixed : precision && task.optimize;
    f(Entry<Value>{std::move(key), task.name + suffix, &value, precision, search, open});
  };
  visit("rho", two_phased(task) ? ".early" : "", task.rho, true);
  if (two_phased(task)) visit("rho_late", ".late", task.rho_late, true);
  if (has_fraction(task)) visit("at", ".at", task.at, false);
  for (std::size_t i = 0; i < task.target.size(); ++i) {
    const std::string key = "target." + std::to_string(i);
    visit(key, "." + key, task.target[i], false);
  }
}

/// Calls f(entry) for each open entry of the primitive, in order.
template <class P, class F>
void for_each_open(P& primitive, F&& f) {
  for (auto& task : primitive.tasks) {
    for_each_entry(task, [&](const auto& entry) {
      if (entry.open) f(entry);
    });
  }
}

Error refuse(const Primitive& primitive, const std::string& message) {
  return {Code::config, "primitive '" + primitive.name + "': " + message};
}

/// What of one entry's search is wrong; empty when it is well.
std::string search_complaint(const Entry<const double>& entry) {
  if (!entry.open) return {};
  if (entry.log() && *entry.value <= 0) {
    return entry.precision ? "a precision of 0 has no logarithm; make it positive or set optimize: false"
                           : "only a positive entry has a logarithm; make it so or set scale: linear";
  }
  if (entry.search == nullptr) return {};
  const auto [min, max] = std::pair(entry.search->min, entry.search->max);
  if (min == 0 && max == 0) {
    if (entry.precision && entry.log()) return {};
    return "bounds min and max are needed; only precisions on a log scale take the study's";
  }
  if (!(min < max)) {
    return "min is " + config::detail::format(min) + ", must be below max, " + config::detail::format(max);
  }
  if (entry.log() && min <= 0) return "min must be positive on a log scale";
  if (entry.precision && (min < 0 || max > 1e12)) return "precisions must stay in 0 … 1e12";
  if (entry.key == "at" && (min < 0 || max > 1)) return "the fraction must stay in 0 … 1";
  if (entry.key.starts_with("target") && !(std::abs(min) < 1e6 && max < 1e6)) return "targets must stay below 1e6";
  return {};
}

Status validate_search(const Primitive& primitive, const Task& task, const std::string& key) {
  std::string complaint, known;
  std::set<std::string> keys;
  for_each_entry(task, [&](const Entry<const double>& entry) {
    known += (known.empty() ? "" : ", ") + entry.key;
    keys.insert(entry.key);
    if (complaint.empty() && !search_complaint(entry).empty()) complaint = entry.key + ": " + search_complaint(entry);
  });
  for (const auto& [name, search] : task.search) {
    if (!keys.contains(name)) complaint = "'" + name + "' is no entry of this task; it has " + known;
  }
  if (!complaint.empty()) return refuse(primitive, key + ".search: " + complaint);
  const auto at = task.search.find("at");
  if (task.profile == Profile::ends && at != task.search.end() && !at->second.fixed && at->second.max > 0.5) {
    return refuse(primitive, key + ".search: at: profile ends needs 0 … 0.5");
  }
  return success();
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
  return validate_search(primitive, task, key);
}

}  // namespace

std::vector<OpenEntry> Primitive::open_entries(double log_rho_min, double log_rho_max) const {
  std::vector<OpenEntry> entries;
  for_each_open(*this, [&](const Entry<const double>& entry) {
    const bool log = entry.log();
    const auto coordinate = [log](double value) { return log ? std::log10(value) : value; };
    OpenEntry open{entry.name, log, coordinate(*entry.value), log_rho_min, log_rho_max};
    if (entry.search != nullptr && entry.search->min < entry.search->max) {
      open.lower = coordinate(entry.search->min);
      open.upper = coordinate(entry.search->max);
    }
    entries.push_back(std::move(open));
  });
  return entries;
}

Primitive Primitive::with_entries(const std::vector<double>& coordinates) const {
  Primitive changed = *this;
  std::size_t i = 0;
  for_each_open(changed, [&](const Entry<double>& entry) {
    PRIMO_CHECK(i < coordinates.size(), "fewer coordinates than open entries");
    const double coordinate = coordinates[i++];
    *entry.value = entry.log() ? std::pow(10.0, coordinate) : coordinate;
  });
  PRIMO_CHECK(i == coordinates.size(), "more coordinates than open entries");
  return changed;
}

std::vector<double> Primitive::log_rho() const {
  std::vector<double> values;
  for_each_open(*this, [&](const Entry<const double>& entry) {
    if (entry.precision) values.push_back(std::log10(*entry.value));
  });
  return values;
}

std::vector<std::string> Primitive::rho_names() const {
  std::vector<std::string> names;
  for_each_open(*this, [&](const Entry<const double>& entry) {
    if (entry.precision) names.push_back(entry.name);
  });
  return names;
}

Primitive Primitive::with_log_rho(const std::vector<double>& values) const {
  Primitive changed = *this;
  std::size_t i = 0;
  for_each_open(changed, [&](const Entry<double>& entry) {
    if (!entry.precision) return;
    PRIMO_CHECK(i < values.size(), "fewer log ρ than open precisions");
    *entry.value = std::pow(10.0, values[i++]);
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
