// Plans and verdicts as JSON for other programs. Radians, metres, seconds.
#pragma once

#include <nlohmann/json.hpp>
#include <string>

#include "core/result.h"
#include "motion/measures.h"
#include "motion/plan.h"
#include "physics/verdict.h"

namespace primo::tool {

/// {"status", "reason", "start", "iterations", "rejected", "evaluations", "cost": {"initial", "final", "control",
/// "tasks": {name: cost}}, "gradient_norm", "time_ms", "min_distance_m", "min_limit_margin_rad", "path_length_rad"}
nlohmann::ordered_json to_json(const motion::Plan& plan, const motion::Measures& measures, double milliseconds);

/// {"success", …, "criteria": [{"name", "value", "margin", "indicator": 0 or 1}], "symbols_before", "symbols_after",
/// "displacement_m", "survivals": [{"amplitude", "held", "seeds", "survival", "displacement_m"}], "contacts":
/// [{"bodies", "begin_s", "end_s", "peak_force_N"}], "unlisted_contacts", "time_ms", "steps"}
nlohmann::ordered_json to_json(const physics::Verdict& verdict, double milliseconds);

/// {"joints": names, "dt", "iterations": accepted and rejected, "q": (T+1) rows of n, "gains": {"K": T matrices n × 2n,
/// "k": T of n}}
nlohmann::ordered_json trajectory_json(const motion::Plan& plan);

/// Reads a trajectory file; gains and iterations may be missing. Errors (data) name the key.
Result<motion::Plan> plan_from_json(const std::string& text);

}  // namespace primo::tool
