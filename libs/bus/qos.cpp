#include "bus/qos.h"

#include <algorithm>
#include <array>
#include <limits>

namespace primo::bus {

using namespace eprosima::fastdds::dds;  // NOLINT: this file is about nothing else
using eprosima::fastrtps::Duration_t;

namespace {

Duration_t duration(std::chrono::milliseconds time) {
  return {static_cast<std::int32_t>(time.count() / 1000), static_cast<std::uint32_t>(time.count() % 1000) * 1000000u};
}

/// A lost sample of a job is noticed, and asked for, this much later.
const Duration_t kJobRepair = duration(std::chrono::milliseconds(200));

/// What both sides have in common.
template <class Qos>
void common(Qos& qos, const TopicInfo& topic, Quality quality, std::chrono::milliseconds lease) {
  qos.reliability().kind = RELIABLE_RELIABILITY_QOS;
  qos.reliability().max_blocking_time = duration(std::chrono::seconds(2));
  const bool kept = quality == Quality::latched || quality == Quality::log || quality == Quality::status;
  qos.durability().kind = kept ? TRANSIENT_LOCAL_DURABILITY_QOS : VOLATILE_DURABILITY_QOS;
  const bool keyed = quality == Quality::latched || quality == Quality::status;
  if (quality == Quality::job || quality == Quality::log) {
    qos.history().kind = KEEP_ALL_HISTORY_QOS;
  } else {
    qos.history().kind = KEEP_LAST_HISTORY_QOS;
    qos.history().depth = keyed ? 1 : std::max(1, std::min(5, topic.limit));
  }
  qos.resource_limits().max_samples = topic.limit;
  qos.resource_limits().max_instances = topic.key.empty() ? 1 : topic.limit;
  qos.resource_limits().max_samples_per_instance = topic.key.empty() ? topic.limit : 1;
  qos.resource_limits().allocated_samples = std::min(topic.limit, 16);
  if (quality == Quality::status) {
    // With AUTOMATIC liveliness a dead writer goes unnoticed while another one lives (Fast DDS #4373).
    qos.liveliness().kind = MANUAL_BY_TOPIC_LIVELINESS_QOS;
    qos.liveliness().lease_duration = duration(lease);
  }
  // Samples hold strings and sequences: payloads of their real size, no memory shared as it is.
  qos.endpoint().history_memory_policy = eprosima::fastrtps::rtps::DYNAMIC_REUSABLE_MEMORY_MODE;
  qos.data_sharing().off();
}

std::string seconds_text(double value) {
  if (value == std::numeric_limits<double>::infinity()) return "infinite";
  std::string text = std::to_string(value);
  text.erase(text.find_last_not_of('0') + 1);
  if (text.back() == '.') text.pop_back();
  return text + " s";
}

}  // namespace

DataWriterQos writer_qos(const TopicInfo& topic, Quality quality, std::chrono::milliseconds lease) {
  DataWriterQos qos = DATAWRITER_QOS_DEFAULT;
  common(qos, topic, quality, lease);
  auto& times = qos.reliable_writer_qos().times;
  times.heartbeatPeriod = duration(std::chrono::milliseconds(20));
  if (quality == Quality::job) {
    // Between processes of a host hardly a sample is lost, and each of these wakes several threads: a heartbeat all of
    // its readers', the end of nack suppression (without a time: after every sample) the writer's own.
    times.heartbeatPeriod = kJobRepair;
    times.nackSupressionDuration = kJobRepair;
  }
  if (quality == Quality::status) qos.liveliness().announcement_period = duration(lease / 4);
  return qos;
}

DataReaderQos reader_qos(const TopicInfo& topic, Quality quality, std::chrono::milliseconds lease) {
  DataReaderQos qos = DATAREADER_QOS_DEFAULT;
  common(qos, topic, quality, lease);
  if (quality == Quality::job) {
    // An acknowledgement for many samples: with the default of 5 ms each has its own.
    qos.reliable_reader_qos().times.heartbeatResponseDelay = kJobRepair;
  }
  return qos;
}

double seconds(const Duration_t& duration) {
  if (duration == eprosima::fastrtps::c_TimeInfinite) return std::numeric_limits<double>::infinity();
  return duration.seconds + duration.nanosec * 1e-9;
}

std::string policy_name(QosPolicyId_t policy) {
  static constexpr std::array<const char*, 24> names = {"INVALID",
                                                        "USER_DATA",
                                                        "DURABILITY",
                                                        "PRESENTATION",
                                                        "DEADLINE",
                                                        "LATENCY_BUDGET",
                                                        "OWNERSHIP",
                                                        "OWNERSHIP_STRENGTH",
                                                        "LIVELINESS",
                                                        "TIME_BASED_FILTER",
                                                        "PARTITION",
                                                        "RELIABILITY",
                                                        "DESTINATION_ORDER",
                                                        "HISTORY",
                                                        "RESOURCE_LIMITS",
                                                        "ENTITY_FACTORY",
                                                        "WRITER_DATA_LIFECYCLE",
                                                        "READER_DATA_LIFECYCLE",
                                                        "TOPIC_DATA",
                                                        "GROUP_DATA",
                                                        "TRANSPORT_PRIORITY",
                                                        "LIFESPAN",
                                                        "DURABILITY_SERVICE",
                                                        "DATA_REPRESENTATION"};
  const auto index = static_cast<std::size_t>(policy);
  return index < names.size() ? names[index] : "policy " + std::to_string(index);
}

std::string policy_value(QosPolicyId_t policy, const Policies& policies) {
  switch (policy) {
    case RELIABILITY_QOS_POLICY_ID:
      return policies.reliability == RELIABLE_RELIABILITY_QOS ? "RELIABLE" : "BEST_EFFORT";
    case DURABILITY_QOS_POLICY_ID: {
      static constexpr std::array<const char*, 4> names = {"VOLATILE", "TRANSIENT_LOCAL", "TRANSIENT", "PERSISTENT"};
      return names[std::min<std::size_t>(policies.durability, 3)];
    }
    case LIVELINESS_QOS_POLICY_ID: {
      static constexpr std::array<const char*, 3> names = {"AUTOMATIC", "MANUAL_BY_PARTICIPANT", "MANUAL_BY_TOPIC"};
      return std::string(names[std::min<std::size_t>(policies.liveliness, 2)]) + " with a lease of " +
             seconds_text(policies.lease);
    }
    case DEADLINE_QOS_POLICY_ID:
      return seconds_text(policies.deadline);
    case OWNERSHIP_QOS_POLICY_ID:
      return policies.ownership == SHARED_OWNERSHIP_QOS ? "SHARED" : "EXCLUSIVE";
    default:
      return "";
  }
}

bool mismatch(QosPolicyId_t policy, const Policies& offered, const Policies& requested) {
  switch (policy) {
    case RELIABILITY_QOS_POLICY_ID:
      return offered.reliability < requested.reliability;
    case DURABILITY_QOS_POLICY_ID:
      return offered.durability < requested.durability;
    case LIVELINESS_QOS_POLICY_ID:
      return offered.liveliness < requested.liveliness || offered.lease > requested.lease;
    case DEADLINE_QOS_POLICY_ID:
      return offered.deadline > requested.deadline;
    case OWNERSHIP_QOS_POLICY_ID:
      return offered.ownership != requested.ownership;
    default:
      return false;
  }
}

}  // namespace primo::bus
