// The one table of topics: name, type, quality of service, key. idl/topics.md is its page for people; a test compares
// the two.
#pragma once

#include <span>
#include <string>
#include <string_view>

namespace sensor_msgs::msg {
class PointCloud2;
}
namespace primo_msgs::msg {
class CameraJob;
class CameraReply;
class PerceptionJob;
class PerceptionReply;
class PlanJob;
class PlanReply;
class JudgeJob;
class JudgeReply;
class SceneEstimate;
class Experience;
class RuleSet;
class OptimizedPrimitive;
class OptimizeGoal;
class Progress;
class WorkerStatus;
}  // namespace primo_msgs::msg

namespace primo::bus {

/// How a topic is kept and delivered. All are RELIABLE.
enum class Quality {
  job,      ///< VOLATILE, keep-all, in a worker's or requester's partition
  latched,  ///< TRANSIENT_LOCAL, keep-last 1 for each key: a late joiner gets the present state
  log,      ///< TRANSIENT_LOCAL, keep-all: a late joiner gets everything
  status,   ///< latched, and MANUAL_BY_TOPIC liveliness
  stream,   ///< VOLATILE, keep-last 5: ROS 2's defaults
};

struct TopicInfo {
  std::string_view name;  ///< as on the wire: "rt/primo/v1/…"
  std::string_view type;  ///< as on the wire: "primo_msgs::msg::dds_::…_"
  Quality quality;
  std::string_view key;  ///< its key fields, "" when there is none
  int limit;             ///< samples kept at most by a writer, and by a reader before they are taken
};

std::string_view to_string(Quality quality);

/// All of them, in the order of the page.
std::span<const TopicInfo> topics();

/// The row of this name. @pre it exists
const TopicInfo& topic_info(std::string_view name);

/// A topic that carries T.
template <class T>
struct Topic {
  std::string_view name;
};

/// The two topics of one kind of job and the role of the workers that do it.
template <class Request, class Reply>
struct JobTopics {
  std::string_view role;
  Topic<Request> request;
  Topic<Reply> reply;
};

}  // namespace primo::bus

namespace primo::topics {

namespace msg = primo_msgs::msg;
using bus::JobTopics;
using bus::Topic;

inline constexpr JobTopics<msg::CameraJob, msg::CameraReply> kCamera{
    "camera", {"rt/primo/v1/camera_job"}, {"rt/primo/v1/camera_reply"}};
inline constexpr JobTopics<msg::PerceptionJob, msg::PerceptionReply> kPerception{
    "perception", {"rt/primo/v1/perception_job"}, {"rt/primo/v1/perception_reply"}};
inline constexpr JobTopics<msg::PlanJob, msg::PlanReply> kPlan{
    "planner", {"rt/primo/v1/plan_job"}, {"rt/primo/v1/plan_reply"}};
inline constexpr JobTopics<msg::JudgeJob, msg::JudgeReply> kJudge{
    "judge", {"rt/primo/v1/judge_job"}, {"rt/primo/v1/judge_reply"}};

inline constexpr Topic<msg::SceneEstimate> kScene{"rt/primo/v1/scene"};
inline constexpr Topic<msg::Experience> kExperience{"rt/primo/v1/experience"};
inline constexpr Topic<msg::RuleSet> kRuleSet{"rt/primo/v1/rule_set"};
inline constexpr Topic<msg::OptimizedPrimitive> kPrimitive{"rt/primo/v1/primitive"};
inline constexpr Topic<msg::OptimizeGoal> kOptimizeGoal{"rt/primo/v1/optimize_goal"};
inline constexpr Topic<msg::Progress> kProgress{"rt/primo/v1/progress"};
inline constexpr Topic<msg::WorkerStatus> kWorkerStatus{"rt/primo/v1/worker_status"};
inline constexpr Topic<sensor_msgs::msg::PointCloud2> kPoints{"rt/points"};

}  // namespace primo::topics
