// What the journal holds, as JSON that reads back to the same bits, and the keys under which it is found.
#pragma once

#include <string>
#include <vector>

#include "study/backend.h"
#include "study/result.h"

namespace primo::study {

std::string encode(const RolloutResult& result);
std::string encode(
    const scene::SceneEstimate& estimate);  ///< without the octree, which neither planner nor judge reads
std::string encode(const OptimizeResult& result);

/// Errors (data): not JSON, a field that is missing, of another type or out of range.
Result<RolloutResult> decode_rollout_result(const std::string& text);
Result<scene::SceneEstimate> decode_estimate(const std::string& text);
Result<OptimizeResult> decode_optimize_result(const std::string& text);

/// Keys: 32 hexadecimal digits over the whole content of a request.
std::string key_of(const Rollout& rollout);
std::string key_of(const scene::Scenario& scenario);  ///< of its observation
std::string key_of(const OptimizeGoal& goal);         ///< but its directory
std::string key_of(const std::vector<symbols::Experience>& experiences);

}  // namespace primo::study
