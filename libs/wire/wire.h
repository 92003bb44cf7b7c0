// Between the generated message types and the library types. to_wire() never fails; from_wire() trusts nothing: sizes,
// lengths, enums, finite numbers and the bounds of each field are checked, and what is wrong is an Error of Code::data
// that names the field.
#pragma once

#include <primo_jobs.h>
#include <primo_rules.h>
#include <primo_study.h>
#include <ros.h>

#include <string>
#include <vector>

#include "core/result.h"
#include "motion/plan.h"
#include "physics/verdict.h"
#include "rules/analysis.h"
#include "rules/rule.h"
#include "scene/estimate.h"
#include "scene/scenario.h"
#include "study/backend.h"
#include "symbols/literal.h"

namespace primo::wire {

namespace msg = primo_msgs::msg;

msg::Scenario to_wire(const scene::Scenario& scenario);
Result<scene::Scenario> from_wire(const msg::Scenario& message);

msg::PointCloud to_wire(const scene::PointCloud& cloud);
Result<scene::PointCloud> from_wire(const msg::PointCloud& message);

msg::SceneEstimate to_wire(const scene::SceneEstimate& estimate);
Result<scene::SceneEstimate> from_wire(const msg::SceneEstimate& message);

msg::Primitive to_wire(const motion::Primitive& primitive);
Result<motion::Primitive> from_wire(const msg::Primitive& message);

/// Leaves the scene's octree out unless a task of the primitive needs it.
msg::PlanRequest to_wire(const motion::PlanRequest& request);
Result<motion::PlanRequest> from_wire(const msg::PlanRequest& message);

msg::Plan to_wire(const motion::Plan& plan);
Result<motion::Plan> from_wire(const msg::Plan& message);

msg::JudgeSettings to_wire(const physics::JudgeSettings& settings);
Result<physics::JudgeSettings> from_wire(const msg::JudgeSettings& message);

msg::JudgeRequest to_wire(const physics::JudgeRequest& request);
Result<physics::JudgeRequest> from_wire(const msg::JudgeRequest& message);

msg::Verdict to_wire(const physics::Verdict& verdict);
Result<physics::Verdict> from_wire(const msg::Verdict& message);

msg::Literal to_wire(const symbols::Literal& literal);
Result<symbols::Literal> from_wire(const msg::Literal& message);

msg::Experience to_wire(const symbols::Experience& experience, const std::string& batch);
Result<symbols::Experience> from_wire(const msg::Experience& message);

/// Rules with what they were learned from: `batch`, the topic's key `action` ("*" when they are about all actions), the
/// number of experiences and the digest over their ids (see experience_digest()).
msg::RuleSet to_wire(const rules::RuleSet& rules, const std::string& batch, const std::string& action, int experiences,
                     const std::string& digest);
/// What is new in a rule set of a batch.
struct RuleSetNews {
  std::uint32_t version = 0;
  double score = 0;
  rules::Difference difference;
};
void add_news(const RuleSetNews& news, msg::RuleSet& message);
/// Error also when the message says that nothing could be learned.
Result<rules::RuleSet> from_wire(const msg::RuleSet& message);
/// 16 hex digits over the ids in order of id; the order given doesn't matter.
std::string experience_digest(const std::vector<std::string>& ids);

msg::OptimizeGoal to_wire(const study::OptimizeGoal& goal);
Result<study::OptimizeGoal> from_wire(const msg::OptimizeGoal& message);

msg::OptimizedPrimitive to_wire(const study::OptimizeResult& result);
/// Error also when the message says that the optimization failed.
Result<study::OptimizeResult> from_wire(const msg::OptimizedPrimitive& message);

/// The cloud in its camera's frame, as float32 x y z, little endian, unorganised.
sensor_msgs::msg::PointCloud2 to_ros(const scene::PointCloud& cloud, const std::string& frame);
/// Reads float32 x, y, z at whatever offsets the fields say; points that are not finite are left out. X_WC is not in
/// the message: it is the identity.
Result<scene::PointCloud> from_ros(const sensor_msgs::msg::PointCloud2& message);

}  // namespace primo::wire
