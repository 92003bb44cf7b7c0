#include "bus/topics.h"

#include <primo_jobsPubSubTypes.h>
#include <primo_rulesPubSubTypes.h>
#include <primo_scenePubSubTypes.h>
#include <primo_statusPubSubTypes.h>
#include <primo_studyPubSubTypes.h>
#include <rosPubSubTypes.h>

#include <array>

#include "bus/dds_type.h"
#include "core/check.h"

namespace primo::bus {
namespace {

using eprosima::fastdds::dds::TypeSupport;

struct Row {
  TopicInfo info;
  std::type_index sample;
  TypeSupport (*type)();
};

template <class PubSubType>
Row row(std::string_view name, std::string_view type, Quality quality, std::string_view key, int limit) {
  return {{name, type, quality, key, limit}, typeid(typename PubSubType::type), [] {
            return TypeSupport(new PubSubType());
          }};
}

#define PRIMO_TOPIC(NAME, MODULE, TYPE, QUALITY, KEY, LIMIT) \
  row<MODULE::msg::TYPE##PubSubType>(NAME, #MODULE "::msg::dds_::" #TYPE "_", Quality::QUALITY, KEY, LIMIT)

const auto& table() {
  static const std::array rows = {
      PRIMO_TOPIC("rt/primo/v1/camera_job", primo_msgs, CameraJob, job, "", 1000),
      PRIMO_TOPIC("rt/primo/v1/camera_reply", primo_msgs, CameraReply, job, "", 1000),
      PRIMO_TOPIC("rt/primo/v1/perception_job", primo_msgs, PerceptionJob, job, "", 1000),
      PRIMO_TOPIC("rt/primo/v1/perception_reply", primo_msgs, PerceptionReply, job, "", 1000),
      PRIMO_TOPIC("rt/primo/v1/plan_job", primo_msgs, PlanJob, job, "", 1000),
      PRIMO_TOPIC("rt/primo/v1/plan_reply", primo_msgs, PlanReply, job, "", 1000),
      PRIMO_TOPIC("rt/primo/v1/judge_job", primo_msgs, JudgeJob, job, "", 1000),
      PRIMO_TOPIC("rt/primo/v1/judge_reply", primo_msgs, JudgeReply, job, "", 1000),
      PRIMO_TOPIC("rt/primo/v1/scene", primo_msgs, SceneEstimate, latched, "scene", 4096),
      PRIMO_TOPIC("rt/primo/v1/experience", primo_msgs, Experience, log, "", 100000),
      PRIMO_TOPIC("rt/primo/v1/rule_set", primo_msgs, RuleSet, latched, "action", 4096),
      PRIMO_TOPIC("rt/primo/v1/primitive", primo_msgs, OptimizedPrimitive, latched, "action", 4096),
      PRIMO_TOPIC("rt/primo/v1/optimize_goal", primo_msgs, OptimizeGoal, latched, "study", 4096),
      PRIMO_TOPIC("rt/primo/v1/progress", primo_msgs, Progress, latched, "source, study", 4096),
      PRIMO_TOPIC("rt/primo/v1/worker_status", primo_msgs, WorkerStatus, status, "worker", 4096),
      PRIMO_TOPIC("rt/points", sensor_msgs, PointCloud2, stream, "", 5),
  };
  return rows;
}

#undef PRIMO_TOPIC

const Row& find_row(std::string_view name) {
  for (const Row& candidate : table()) {
    if (candidate.info.name == name) return candidate;
  }
  check_failed("topic exists", __FILE__, __LINE__, "no topic '" + std::string(name) + "' in the table of topics");
}

}  // namespace

std::string_view to_string(Quality quality) {
  switch (quality) {
    case Quality::job:
      return "job";
    case Quality::latched:
      return "latched";
    case Quality::log:
      return "log";
    case Quality::status:
      return "status";
    case Quality::stream:
      return "stream";
  }
  return "unknown";
}

std::span<const TopicInfo> topics() {
  static const auto infos = [] {
    std::vector<TopicInfo> all;
    for (const Row& entry : table()) all.push_back(entry.info);
    return all;
  }();
  return infos;
}

const TopicInfo& topic_info(std::string_view name) { return find_row(name).info; }

TypeSupport generated_type(const TopicInfo& topic) { return find_row(topic.name).type(); }

std::type_index sample_type(const TopicInfo& topic) { return find_row(topic.name).sample; }

}  // namespace primo::bus
