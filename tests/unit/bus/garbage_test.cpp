#include <primo_rules.h>

#include <algorithm>
#include <atomic>
#include <cstring>
#include <fastdds/dds/domain/DomainParticipant.hpp>
#include <fastdds/dds/domain/DomainParticipantFactory.hpp>
#include <fastdds/dds/publisher/DataWriter.hpp>
#include <fastdds/dds/publisher/Publisher.hpp>

#include "bus/dds_type.h"
#include "bus/latched.h"
#include "bus/qos.h"
#include "core/random.h"
#include "fixture.h"

namespace primo::bus {
namespace {

namespace dds = eprosima::fastdds::dds;
using primo_msgs::msg::Experience;

/// A type that sends whatever bytes it is given under the name of another.
class Bytes : public dds::TopicDataType {
 public:
  explicit Bytes(std::string_view name) {
    setName(std::string(name).c_str());
    m_typeSize = 10000;
    m_isGetKeyDefined = false;
    auto_fill_type_object(false);
    auto_fill_type_information(false);
  }
  bool serialize(void* data, eprosima::fastrtps::rtps::SerializedPayload_t* payload) override {
    const auto& bytes = *static_cast<std::vector<unsigned char>*>(data);
    std::memcpy(payload->data, bytes.data(), bytes.size());
    payload->length = static_cast<std::uint32_t>(bytes.size());
    return true;
  }
  bool deserialize(eprosima::fastrtps::rtps::SerializedPayload_t*, void*) override { return false; }
  std::function<std::uint32_t()> getSerializedSizeProvider(void* data) override {
    return [data] { return static_cast<std::uint32_t>(static_cast<std::vector<unsigned char>*>(data)->size()); };
  }
  void* createData() override { return new std::vector<unsigned char>; }
  void deleteData(void* data) override { delete static_cast<std::vector<unsigned char>*>(data); }
  bool getKey(void*, eprosima::fastrtps::rtps::InstanceHandle_t*, bool) override { return false; }
};

TEST(Garbage, on_a_topic_is_reported_and_dropped_and_the_good_samples_around_it_arrive) {
  const Participant victim = make_participant("victim");
  std::atomic<int> good{0};
  const auto subscription = Subscription<Experience>::create(victim, topics::kExperience, [&](Experience&& sample) {
                              good += sample.id() == "good";
                            }).value();

  auto* factory = dds::DomainParticipantFactory::get_instance();
  auto* attacker = factory->create_participant(static_cast<std::uint32_t>(test_domain()), dds::PARTICIPANT_QOS_DEFAULT);
  ASSERT_NE(attacker, nullptr);
  const TopicInfo& info = topic_info(topics::kExperience.name);
  dds::TypeSupport type(new Bytes(info.type));
  type.register_type(attacker);
  auto* topic = attacker->create_topic(std::string(info.name), type.get_type_name(), dds::TOPIC_QOS_DEFAULT);
  auto* publisher = attacker->create_publisher(dds::PUBLISHER_QOS_DEFAULT);
  auto* writer = publisher->create_datawriter(topic, writer_qos(info, info.quality, std::chrono::milliseconds(500)));
  ASSERT_NE(writer, nullptr);

  auto honest_type = generated_type(info);
  Experience honest;
  honest.id("good");
  eprosima::fastrtps::rtps::SerializedPayload_t payload(1000);
  ASSERT_TRUE(honest_type.serialize(&honest, &payload));
  for (std::uint64_t i = 0; i < 20; ++i) {
    Random random(i, "garbage");
    std::vector<unsigned char> bytes(4 + random.below(200));
    for (auto& byte : bytes) byte = static_cast<unsigned char>(random.bits());
    bytes[0] = 0, bytes[1] = 1;             // a right encapsulation, so that the rest is looked at
    if (bytes.size() > 8) bytes[7] = 0xff;  // a first string of gigabytes
    writer->write(&bytes);
    bytes.assign(payload.data, payload.data + payload.length);
    writer->write(&bytes);
  }
  EXPECT_TRUE(eventually([&] { return good == 20; })) << good;
  ASSERT_TRUE(eventually([&] { return !victim.problems().empty(); }));
  EXPECT_NE(victim.problems().front().find("malformed sample on topic rt/primo/v1/experience"), std::string::npos);
  attacker->delete_contained_entities();
  factory->delete_participant(attacker);
}

TEST(Garbage, of_any_type_is_deserialised_or_refused_without_harm) {
  for (const TopicInfo& topic : topics()) {
    GuardedType guarded(generated_type(topic), 1u << 20);
    for (std::uint64_t run = 0; run < 300; ++run) {
      Random random(run, topic.name);
      const auto size = static_cast<std::uint32_t>(4 + random.below(400));
      eprosima::fastrtps::rtps::SerializedPayload_t payload(size);
      payload.length = size;
      for (std::uint32_t i = 0; i < size; ++i) payload.data[i] = static_cast<unsigned char>(random.bits());
      if (run % 2 == 0) std::fill_n(payload.data, 4, static_cast<unsigned char>(0)), payload.data[1] = 1;
      void* sample = guarded.createData();
      EXPECT_TRUE(guarded.deserialize(&payload, sample));
      (void)GuardedType::take_failure();
      eprosima::fastrtps::rtps::InstanceHandle_t handle;
      (void)guarded.getKey(sample, &handle, false);
      guarded.deleteData(sample);
    }
  }
}

TEST(Garbage, a_payload_over_the_limit_is_not_even_looked_at) {
  GuardedType guarded(generated_type(topic_info(topics::kPoints.name)), 100);
  eprosima::fastrtps::rtps::SerializedPayload_t payload(101);
  payload.length = 101;
  std::fill_n(payload.data, 101, static_cast<unsigned char>(0));
  void* sample = guarded.createData();
  guarded.deserialize(&payload, sample);
  EXPECT_TRUE(GuardedType::take_failure());
  EXPECT_FALSE(GuardedType::take_failure());
  guarded.deleteData(sample);
}

}  // namespace
}  // namespace primo::bus
