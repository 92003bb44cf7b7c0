// Facts: what is published once and reaches every present and later subscriber (Quality::latched and ::log), and
// streams.
#pragma once

#include <functional>
#include <memory>
#include <typeinfo>
#include <utility>

#include "bus/endpoint.h"

namespace primo::bus {

template <class T>
class Publisher {
 public:
  static Result<Publisher> create(const Participant& participant, const Topic<T>& topic, EndpointOptions options = {}) {
    PRIMO_ASSIGN(auto writer, Writer::create(participant, topic_info(topic.name), typeid(T), std::move(options)));
    return Publisher(std::move(writer));
  }
  Status publish(const T& sample) { return writer_->write(&sample); }
  int matched() const { return writer_->matched(); }
  bool wait_matched(int count, std::chrono::milliseconds timeout) const {
    return writer_->wait_matched(count, timeout);
  }
  bool wait_acknowledged(std::chrono::milliseconds timeout) { return writer_->wait_acknowledged(timeout); }

 private:
  explicit Publisher(std::unique_ptr<Writer> writer) : writer_(std::move(writer)) {}
  std::unique_ptr<Writer> writer_;
};

template <class T>
class Subscription {
 public:
  /// `on_sample` runs on the subscription's own thread, one sample at a time, in each writer's order.
  static Result<Subscription> create(const Participant& participant, const Topic<T>& topic,
                                     std::function<void(T&& sample)> on_sample, EndpointOptions options = {}) {
    ReaderCallbacks callbacks;
    callbacks.on_sample = [on_sample = std::move(on_sample)](void* sample, const Origin&) {
      on_sample(std::move(*static_cast<T*>(sample)));
    };
    PRIMO_ASSIGN(auto reader, Reader::create(participant, topic_info(topic.name), typeid(T), std::move(callbacks),
                                             std::move(options)));
    return Subscription(std::move(reader));
  }
  int matched() const { return reader_->matched(); }

 private:
  explicit Subscription(std::unique_ptr<Reader> reader) : reader_(std::move(reader)) {}
  std::unique_ptr<Reader> reader_;
};

}  // namespace primo::bus
