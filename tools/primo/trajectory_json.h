// Plans and verdicts as JSON for other programs. Radians, metres, seconds.
#pragma once

#include <nlohmann/json.hpp>
#include <string>

#include "core/result.h"
#include "motion/plan.h"
#include "physics/verdict.h"

namespace primo::tool {

/// {"status", "reason", "start", "iterations", "rejected", "cost": {…}, "tasks": {name: cost}, "trajectory": {"joints",
/// "dt", "q": (T+1) rows of n}}
nlohmann::ordered_json to_json(const motion::Plan& plan);
nlohmann::ordered_json to_json(const physics::Verdict& verdict);

/// Reads what is needed to judge a plan: status, iterations and trajectory. Errors (data) name the key.
Result<motion::Plan> plan_from_json(const std::string& text);

}  // namespace primo::tool
