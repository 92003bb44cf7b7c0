// The types that readers and writers work with: the generated ones behind a guard.
#pragma once

#include <fastdds/dds/topic/TypeSupport.hpp>
#include <mutex>
#include <typeindex>

#include "bus/topics.h"

namespace primo::bus {

/// A generated type whose (de)serialisation cannot throw, is bounded in size, and may be used from several threads. A
/// sample that cannot be deserialised counts as taken, so that it leaves the history; take_failure() then says so to
/// the thread that took it.
class GuardedType : public eprosima::fastdds::dds::TopicDataType {
 public:
  GuardedType(eprosima::fastdds::dds::TypeSupport inner, std::uint32_t max_bytes);

  bool serialize(void* data, eprosima::fastrtps::rtps::SerializedPayload_t* payload) override;
  bool deserialize(eprosima::fastrtps::rtps::SerializedPayload_t* payload, void* data) override;
  std::function<std::uint32_t()> getSerializedSizeProvider(void* data) override;
  void* createData() override { return inner_.create_data(); }
  void deleteData(void* data) override { inner_.delete_data(data); }
  bool getKey(void* data, eprosima::fastrtps::rtps::InstanceHandle_t* handle, bool force_md5) override;
  bool is_bounded() const override { return false; }
  bool is_plain() const override { return false; }

  std::uint32_t max_bytes() const { return max_bytes_; }
  /// Whether the calling thread's last deserialize() failed; resets it.
  static bool take_failure();

 private:
  eprosima::fastdds::dds::TypeSupport inner_;
  std::uint32_t max_bytes_;
  std::mutex key_mutex_;
};

/// The generated type of a topic.
eprosima::fastdds::dds::TypeSupport generated_type(const TopicInfo& topic);
/// The C++ type of a topic's samples.
std::type_index sample_type(const TopicInfo& topic);

}  // namespace primo::bus
