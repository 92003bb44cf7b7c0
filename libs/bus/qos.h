// Qualities as DDS policies, and policies in words.
#pragma once

#include <chrono>
#include <fastdds/dds/core/policy/QosPolicies.hpp>
#include <fastdds/dds/publisher/qos/DataWriterQos.hpp>
#include <fastdds/dds/subscriber/qos/DataReaderQos.hpp>
#include <optional>
#include <string>

#include "bus/topics.h"

namespace primo::bus {

eprosima::fastdds::dds::DataWriterQos writer_qos(const TopicInfo& topic, Quality quality,
                                                 std::chrono::milliseconds lease);
eprosima::fastdds::dds::DataReaderQos reader_qos(const TopicInfo& topic, Quality quality,
                                                 std::chrono::milliseconds lease);

/// The policies by which a reader and a writer may refuse each other, of either side.
struct Policies {
  eprosima::fastdds::dds::ReliabilityQosPolicyKind reliability;
  eprosima::fastdds::dds::DurabilityQosPolicyKind durability;
  eprosima::fastdds::dds::LivelinessQosPolicyKind liveliness;
  double lease = 0;     ///< s
  double deadline = 0;  ///< s
  eprosima::fastdds::dds::OwnershipQosPolicyKind ownership;
};

double seconds(const eprosima::fastrtps::Duration_t& duration);

/// From writer or reader QoS of the DDS API.
template <class Qos>
Policies policies_of(const Qos& qos) {
  return {qos.reliability().kind,         qos.durability().kind,
          qos.liveliness().kind,          seconds(qos.liveliness().lease_duration),
          seconds(qos.deadline().period), qos.ownership().kind};
}
/// From what discovery says of another's endpoint.
template <class Qos>
Policies policies_of_remote(const Qos& qos) {
  return {qos.m_reliability.kind,         qos.m_durability.kind,
          qos.m_liveliness.kind,          seconds(qos.m_liveliness.lease_duration),
          seconds(qos.m_deadline.period), qos.m_ownership.kind};
}

std::string policy_name(eprosima::fastdds::dds::QosPolicyId_t policy);
/// The policy's value in words; empty when Policies doesn't hold it.
std::string policy_value(eprosima::fastdds::dds::QosPolicyId_t policy, const Policies& policies);
/// Whether the writer's offer doesn't meet the reader's request in this policy.
bool mismatch(eprosima::fastdds::dds::QosPolicyId_t policy, const Policies& offered, const Policies& requested);

}  // namespace primo::bus
