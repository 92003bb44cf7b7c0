#include "bus/endpoint.h"

#include <atomic>
#include <cstring>
#include <fastdds/dds/publisher/DataWriter.hpp>
#include <fastdds/dds/publisher/DataWriterListener.hpp>
#include <fastdds/dds/publisher/Publisher.hpp>
#include <fastdds/dds/subscriber/DataReader.hpp>
#include <fastdds/dds/subscriber/DataReaderListener.hpp>
#include <fastdds/dds/subscriber/SampleInfo.hpp>
#include <fastdds/dds/subscriber/Subscriber.hpp>
#include <sstream>

#include "bus/participant_impl.h"

namespace primo::bus {

namespace dds = eprosima::fastdds::dds;
using eprosima::fastrtps::types::ReturnCode_t;

namespace {

Origin origin_of(const dds::InstanceHandle_t& handle) {
  Origin origin{};
  for (std::size_t i = 0; i < origin.size(); ++i) origin[i] = handle.value[i];
  return origin;
}

std::string text_of(const eprosima::fastrtps::rtps::GUID_t& guid) {
  std::ostringstream text;
  text << guid;
  return text.str();
}

eprosima::fastrtps::Duration_t duration(std::chrono::milliseconds time) {
  return {static_cast<std::int32_t>(time.count() / 1000), static_cast<std::uint32_t>(time.count() % 1000) * 1000000u};
}

Error refused(const TopicInfo& topic, const char* what) {
  return {Code::unavailable, "bus: DDS refuses a " + std::string(what) + " of topic " + std::string(topic.name)};
}

}  // namespace

// ---- Writer

struct Writer::Impl : dds::DataWriterListener {
  void on_publication_matched(dds::DataWriter*, const dds::PublicationMatchedStatus& status) override {
    {
      const std::lock_guard lock(mutex);
      matched = status.current_count;
      ever = ever || matched > 0;
    }
    changed.notify_all();
    if (on_matched) on_matched();
  }
  void on_offered_incompatible_qos(dds::DataWriter*, const dds::OfferedIncompatibleQosStatus& status) override {
    participant->report({topic, true, status.last_policy_id, policies,
                         std::chrono::steady_clock::now() + std::chrono::milliseconds(300)});
  }
  ~Impl() override {
    if (writer != nullptr) {
      participant->forget(std::string(topic->name), text_of(writer->guid()));
      writer->set_listener(nullptr);
      publisher->delete_datawriter(writer);
    }
    if (publisher != nullptr) participant->participant->delete_publisher(publisher);
  }

  std::shared_ptr<Participant::Impl> participant;
  const TopicInfo* topic = nullptr;
  Policies policies{};
  std::function<void()> on_matched;
  dds::Publisher* publisher = nullptr;
  dds::DataWriter* writer = nullptr;
  dds::TypeSupport type;
  mutable std::mutex mutex;
  mutable std::condition_variable changed;
  int matched = 0;
  bool ever = false;
};

Writer::Writer(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
Writer::~Writer() = default;

Result<std::unique_ptr<Writer>> Writer::create(const Participant& participant, const TopicInfo& topic,
                                               std::type_index type, EndpointOptions options,
                                               std::function<void()> on_matched) {
  PRIMO_CHECK(type == sample_type(topic), "another type than the topic's: " + std::string(topic.name));
  auto impl = std::make_unique<Impl>();
  impl->participant = participant.impl();
  impl->topic = &topic;
  impl->on_matched = std::move(on_matched);
  dds::Topic* dds_topic = impl->participant->topic(topic);
  if (dds_topic == nullptr) return refused(topic, "type");
  dds::PublisherQos publisher_qos = dds::PUBLISHER_QOS_DEFAULT;
  if (!options.partition.empty()) publisher_qos.partition().push_back(options.partition.c_str());
  impl->publisher = impl->participant->participant->create_publisher(publisher_qos);
  if (impl->publisher == nullptr) return refused(topic, "publisher");
  const auto qos = writer_qos(topic, options.quality.value_or(topic.quality), options.lease);
  impl->policies = policies_of(qos);
  impl->writer = impl->publisher->create_datawriter(dds_topic, qos, impl.get(),
                                                    dds::StatusMask::publication_matched()
                                                        << dds::StatusMask::offered_incompatible_qos());
  if (impl->writer == nullptr) return refused(topic, "writer");
  impl->type = impl->writer->get_type();
  impl->participant->remember(std::string(topic.name), text_of(impl->writer->guid()), {true, impl->policies});
  return std::unique_ptr<Writer>(new Writer(std::move(impl)));
}

Status Writer::write(const void* sample) {
  void* data = const_cast<void*>(sample);
  const auto place = "topic " + std::string(impl_->topic->name);
  const std::uint64_t size = impl_->type->getSerializedSizeProvider(data)();
  if (size > impl_->participant->max_bytes) {
    return Error{Code::data, place + ": a sample of " + std::to_string(size) + " bytes, at most " +
                                 std::to_string(impl_->participant->max_bytes) + " pass (bus.max_sample_mib)"};
  }
  dds::InstanceHandle_t key;
  if (impl_->type->m_isGetKeyDefined && !impl_->type->getKey(data, &key)) {
    return Error{Code::data,
                 place + ": the sample's key (" + std::string(impl_->topic->key) + ") is longer than 255 bytes"};
  }
  const ReturnCode_t code = impl_->writer->write(data, dds::HANDLE_NIL);
  if (code == ReturnCode_t::RETCODE_OK) return success();
  if (code == ReturnCode_t::RETCODE_BAD_PARAMETER || code == ReturnCode_t::RETCODE_ERROR ||
      code == ReturnCode_t::RETCODE_PRECONDITION_NOT_MET) {
    return Error{Code::data, place + ": the sample cannot be serialised"};
  }
  return Error{Code::unavailable, place + ": no room for another sample within 2 s; at most " +
                                      std::to_string(impl_->topic->limit) +
                                      " are kept, and a reader may have stopped taking them"};
}

Status Writer::assert_liveliness() {
  if (impl_->writer->assert_liveliness() == ReturnCode_t::RETCODE_OK) return success();
  return Error{Code::internal, "topic " + std::string(impl_->topic->name) + ": liveliness cannot be asserted"};
}

int Writer::matched() const {
  const std::lock_guard lock(impl_->mutex);
  return impl_->matched;
}

bool Writer::was_matched() const {
  const std::lock_guard lock(impl_->mutex);
  return impl_->ever;
}

bool Writer::wait_matched(int count, std::chrono::milliseconds timeout) const {
  std::unique_lock lock(impl_->mutex);
  return impl_->changed.wait_for(lock, timeout, [&] { return impl_->matched >= count; });
}

bool Writer::wait_acknowledged(std::chrono::milliseconds timeout) {
  return impl_->writer->wait_for_acknowledgments(duration(timeout)) == ReturnCode_t::RETCODE_OK;
}

// ---- Reader

// Listeners only leave word for the reader's thread. (A WaitSet on the reader's status would do the same but for a gap:
// taking a sample resets the status, also when the next one has just arrived.)
struct Reader::Impl : dds::DataReaderListener {
  void on_data_available(dds::DataReader*) override {
    {
      const std::lock_guard lock(mutex);
      data_waits = true;
    }
    changed.notify_one();
  }
  void on_subscription_matched(dds::DataReader*, const dds::SubscriptionMatchedStatus& status) override {
    matched = status.current_count;
    // With a finite lease it is liveliness that says who is alive; being unmatched is the end in any case.
    if (status.current_count_change < 0 || !has_lease) {
      note(origin_of(status.last_publication_handle), status.current_count_change > 0);
    }
  }
  void on_liveliness_changed(dds::DataReader*, const dds::LivelinessChangedStatus& status) override {
    if (has_lease && status.alive_count_change != 0) {
      note(origin_of(status.last_publication_handle), status.alive_count_change > 0);
    }
  }
  void on_requested_incompatible_qos(dds::DataReader*, const dds::RequestedIncompatibleQosStatus& status) override {
    participant->report({topic, false, status.last_policy_id, policies,
                         std::chrono::steady_clock::now() + std::chrono::milliseconds(300)});
  }
  void note(const Origin& origin, bool alive) {
    if (!callbacks.on_writer) return;
    {
      const std::lock_guard lock(mutex);
      events.emplace_back(origin, alive);
    }
    changed.notify_one();
  }

  void run();
  bool take_all();
  ~Impl() override;

  std::shared_ptr<Participant::Impl> participant;
  const TopicInfo* topic = nullptr;
  Policies policies{};
  bool has_lease = false;
  ReaderCallbacks callbacks;
  dds::Subscriber* subscriber = nullptr;
  dds::DataReader* reader = nullptr;
  dds::TypeSupport type;
  std::atomic<int> matched{0};
  std::atomic<bool> stop{false};
  std::mutex mutex;
  std::condition_variable changed;
  bool data_waits = false;
  std::deque<std::pair<Origin, bool>> events;
  std::thread thread;
};

Reader::Impl::~Impl() {
  {
    const std::lock_guard lock(mutex);
    stop = true;
  }
  changed.notify_one();
  if (thread.joinable()) thread.join();
  if (reader != nullptr) {
    participant->forget(std::string(topic->name), text_of(reader->guid()));
    reader->set_listener(nullptr);
    subscriber->delete_datareader(reader);
  }
  if (subscriber != nullptr) participant->participant->delete_subscriber(subscriber);
}

/// Takes what is there. False when told to stop.
bool Reader::Impl::take_all() {
  while (!stop) {
    const std::unique_ptr<void, std::function<void(void*)>> sample(type.create_data(),
                                                                   [this](void* data) { type.delete_data(data); });
    dds::SampleInfo info;
    GuardedType::take_failure();
    if (reader->take_next_sample(sample.get(), &info) != ReturnCode_t::RETCODE_OK) return true;
    const bool malformed = GuardedType::take_failure();
    if (!info.valid_data) continue;
    if (malformed) {
      participant->report("malformed sample on topic " + std::string(topic->name) + " from writer " +
                          text_of(info.sample_identity.writer_guid()) + ": it isn't a " + std::string(topic->type) +
                          "; dropped");
      continue;
    }
    callbacks.on_sample(sample.get(), origin_of(info.publication_handle));
  }
  return false;
}

void Reader::Impl::run() {
  while (true) {
    std::deque<std::pair<Origin, bool>> seen;
    {
      std::unique_lock lock(mutex);
      changed.wait(lock, [&] { return stop || data_waits || !events.empty(); });
      if (stop) return;
      data_waits = false;
      seen.swap(events);
    }
    // First the samples, so that a writer's last ones come before the news of its end.
    if (!take_all()) return;
    for (const auto& [origin, alive] : seen) {
      if (stop) return;
      callbacks.on_writer(origin, alive);
    }
  }
}

Reader::Reader(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
Reader::~Reader() = default;

Result<std::unique_ptr<Reader>> Reader::create(const Participant& participant, const TopicInfo& topic,
                                               std::type_index type, ReaderCallbacks callbacks,
                                               EndpointOptions options) {
  PRIMO_CHECK(type == sample_type(topic), "another type than the topic's: " + std::string(topic.name));
  PRIMO_CHECK(callbacks.on_sample != nullptr, "a reader without on_sample");
  auto impl = std::make_unique<Impl>();
  impl->participant = participant.impl();
  impl->topic = &topic;
  impl->callbacks = std::move(callbacks);
  dds::Topic* dds_topic = impl->participant->topic(topic);
  if (dds_topic == nullptr) return refused(topic, "type");
  dds::SubscriberQos subscriber_qos = dds::SUBSCRIBER_QOS_DEFAULT;
  if (!options.partition.empty()) subscriber_qos.partition().push_back(options.partition.c_str());
  impl->subscriber = impl->participant->participant->create_subscriber(subscriber_qos);
  if (impl->subscriber == nullptr) return refused(topic, "subscriber");
  const Quality quality = options.quality.value_or(topic.quality);
  impl->has_lease = quality == Quality::status;
  const auto qos = reader_qos(topic, quality, options.lease);
  impl->policies = policies_of(qos);
  impl->type = impl->participant->participant->find_type(dds_topic->get_type_name());
  impl->reader = impl->subscriber->create_datareader(dds_topic, qos, impl.get(),
                                                     dds::StatusMask::data_available()
                                                         << dds::StatusMask::subscription_matched()
                                                         << dds::StatusMask::requested_incompatible_qos()
                                                         << dds::StatusMask::liveliness_changed());
  if (impl->reader == nullptr) return refused(topic, "reader");
  impl->participant->remember(std::string(topic.name), text_of(impl->reader->guid()), {false, impl->policies});
  impl->thread = std::thread([raw = impl.get()] { raw->run(); });
  return std::unique_ptr<Reader>(new Reader(std::move(impl)));
}

int Reader::matched() const { return impl_->matched; }

}  // namespace primo::bus
