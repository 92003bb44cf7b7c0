#include "bus/dds_type.h"

#include <exception>
#include <utility>

namespace primo::bus {
namespace {
thread_local bool deserialize_failed = false;
}

using eprosima::fastrtps::rtps::InstanceHandle_t;
using eprosima::fastrtps::rtps::SerializedPayload_t;

GuardedType::GuardedType(eprosima::fastdds::dds::TypeSupport inner, std::uint32_t max_bytes)
    : inner_(std::move(inner)), max_bytes_(max_bytes) {
  m_typeSize = 1024;  // a first guess at payloads; the generated worst case of nested sequences overflows
  m_isGetKeyDefined = inner_->m_isGetKeyDefined;
  setName(inner_->getName());
  // Other implementations match @final types only where none of these are announced.
  auto_fill_type_object(false);
  auto_fill_type_information(false);
}

bool GuardedType::serialize(void* data, SerializedPayload_t* payload) {
  try {
    return inner_->serialize(data, payload);
  } catch (const std::exception&) {
    return false;
  }
}

bool GuardedType::deserialize(SerializedPayload_t* payload, void* data) {
  bool ok = false;
  try {
    ok = payload->length <= max_bytes_ && inner_->deserialize(payload, data);
  } catch (const std::exception&) {
  }
  deserialize_failed = !ok;
  return true;
}

std::function<std::uint32_t()> GuardedType::getSerializedSizeProvider(void* data) {
  return inner_->getSerializedSizeProvider(data);
}

bool GuardedType::getKey(void* data, InstanceHandle_t* handle, bool force_md5) {
  const std::lock_guard lock(key_mutex_);  // the generated types compute keys in a buffer of their own
  try {
    return inner_->getKey(data, handle, force_md5);
  } catch (const std::exception&) {
    return false;
  }
}

bool GuardedType::take_failure() { return std::exchange(deserialize_failed, false); }

}  // namespace primo::bus
