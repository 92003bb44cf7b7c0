#include "study/fitness.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numeric>

namespace primo::study {
namespace {

using symbols::Literal;
using Binding = std::map<std::string, std::string>;

/// 0 at `from`, 1 at `to`, linear between; 0 for what is not finite, as nothing good is known of it.
double ramp(double value, double from, double to) {
  if (std::isnan(value)) return 0;
  return std::clamp((value - from) / (to - from), 0.0, 1.0);
}

/// value in [0, cap]; the cap for NaN.
double capped(double value, double cap) { return std::isnan(value) ? cap : std::clamp(value, 0.0, cap); }

bool is_variable(const std::string& term) { return !term.empty() && term[0] >= 'A' && term[0] <= 'Z'; }

/// All bindings of the literal's free variables under which its atom is in the state, given the bound ones.
std::vector<Binding> matches(const Literal& literal, const Binding& bound, const symbols::State& state) {
  std::vector<Binding> found;
  for (const auto& atom : state) {
    if (atom.negated || atom.predicate != literal.predicate || atom.arguments.size() != literal.arguments.size())
      continue;
    Binding binding = bound;
    bool equal = true;
    for (std::size_t i = 0; equal && i < atom.arguments.size(); ++i) {
      const std::string& term = literal.arguments[i];
      equal = is_variable(term) ? binding.emplace(term, atom.arguments[i]).first->second == atom.arguments[i]
                                : term == atom.arguments[i];
    }
    if (equal) found.push_back(std::move(binding));
  }
  return found;
}

bool all_bound(const Literal& literal, const Binding& binding) {
  return std::all_of(literal.arguments.begin(), literal.arguments.end(),
                     [&](const std::string& term) { return !is_variable(term) || binding.contains(term); });
}

/// The judge's own criterion where it gave one, as it knows the margin that was asked for.
bool limits_kept(const physics::Verdict& verdict) {
  for (const auto& criterion : verdict.criteria) {
    if (criterion.name == "limit_margin") return criterion.met;
  }
  return verdict.limit_margin >= 0;
}

/// How far the clearances of a motion count: one that stays away from everything has earned nothing by it.
double nearness(const physics::Verdict& verdict, double near) {
  if (near <= 0) return 1;
  return std::isnan(verdict.position_error) ? 0 : std::exp(-std::max(0.0, verdict.position_error) / near);
}

}  // namespace

Status FitnessSettings::validate() const {
  const auto ordered = [](const char* name, double from, double to) -> Status {
    if (from < to) return primo::success();
    return Error{Code::config, std::string("'") + name + "_from' is " + std::to_string(from) + ", must be below '" +
                                   name + "_to', " + std::to_string(to)};
  };
  PRIMO_TRY(ordered("clearance", clearance_from, clearance_to));
  return ordered("target_clearance", target_clearance_from, target_clearance_to);
}

std::string argument_variable(std::size_t i) {
  static constexpr std::array<const char*, 6> names = {"X", "Y", "Z", "U", "V", "W"};
  return i < names.size() ? names[i] : "A" + std::to_string(i);
}

bool holds_desired(const physics::Verdict& verdict, const std::vector<Literal>& desired,
                   const std::vector<std::string>& action) {
  Binding bound;
  for (std::size_t i = 1; i < action.size(); ++i) bound.emplace(argument_variable(i - 1), action[i]);
  return std::all_of(desired.begin(), desired.end(), [&](const Literal& literal) {
    if (!literal.negated) return !matches(literal, bound, verdict.after).empty();
    if (all_bound(literal, bound)) return matches(literal, bound, verdict.after).empty();
    const auto held = matches(literal, bound, verdict.before);
    return !held.empty() && std::all_of(held.begin(), held.end(), [&](const Binding& binding) {
      return matches(literal, binding, verdict.after).empty();
    });
  });
}

bool succeeded(const RolloutResult& result, const std::vector<Literal>& desired,
               const std::vector<std::string>& action) {
  return result.verdict.success && holds_desired(result.verdict, desired, action);
}

double trajectory_fitness(const RolloutResult& result, bool success, const FitnessSettings& settings) {
  const physics::Verdict& v = result.verdict;
  double g = -settings.path_length * capped(v.path_length, settings.path_length_cap) -
             settings.iterations * std::max(0, result.iterations) -
             settings.speed * capped(v.max_speed - settings.speed_from, settings.speed_range);
  const bool judged = v.outcome != physics::Outcome::bad_plan && v.outcome != physics::Outcome::unstable;
  if (!judged) return std::min(g, 0.0);
  g += settings.success * (success ? 1.0 : 0.0);
  const double clear = ramp(v.clearance, settings.clearance_from, settings.clearance_to);
  const double target_clear = ramp(v.target_clearance, settings.target_clearance_from, settings.target_clearance_to);
  g += settings.score * ramp(v.score, 0, 1) * (1 - settings.clean_share * (1 - clear * target_clear));
  g += nearness(v, settings.near) * (settings.clearance * clear + settings.target_clearance * target_clear);
  g += settings.limits * (limits_kept(v) ? 1.0 : 0.0);
  return g;
}

double signal(const RolloutResult& result, bool success, Signal kind, const FitnessSettings& settings) {
  if (kind == Signal::binary) return success ? 1 : 0;
  return trajectory_fitness(result, success && kind == Signal::mixed, settings);
}

double best_signal(Signal kind, const FitnessSettings& settings) {
  if (kind == Signal::binary) return 1;
  return (kind == Signal::mixed ? settings.success : 0) + settings.score + settings.clearance +
         settings.target_clearance + settings.limits;
}

double worst_fitness(const FitnessSettings& settings, int max_iterations) {
  return -settings.path_length * settings.path_length_cap - settings.iterations * max_iterations -
         settings.speed * settings.speed_range;
}

double fitness(std::span<const double> g) {
  PRIMO_CHECK(!g.empty(), "γ needs at least one scenario");
  return std::accumulate(g.begin(), g.end(), 0.0) / static_cast<double>(g.size());
}

}  // namespace primo::study
