// Inside of Participant; only the bus's own sources include this.
#pragma once

#include <chrono>
#include <condition_variable>
#include <deque>
#include <fastdds/dds/domain/DomainParticipant.hpp>
#include <fastdds/dds/domain/DomainParticipantListener.hpp>
#include <fastdds/dds/topic/Topic.hpp>
#include <map>
#include <mutex>
#include <thread>

#include "bus/dds_type.h"
#include "bus/participant.h"
#include "bus/qos.h"

namespace primo::bus {

struct Participant::Impl {
  /// A mismatch as a listener reports it; it is put in words on the reporter's thread, when discovery has told of the
  /// other side.
  struct Mismatch {
    const TopicInfo* topic;
    bool ours_is_writer;
    eprosima::fastdds::dds::QosPolicyId_t policy;
    Policies ours;
    std::chrono::steady_clock::time_point until;
  };
  struct Endpoint {
    bool is_writer;
    Policies policies;
  };

  Impl() = default;
  Impl(const Impl&) = delete;
  Impl& operator=(const Impl&) = delete;
  ~Impl();
  void start();

  /// The topic with its type, made at first use. nullptr when DDS refuses.
  eprosima::fastdds::dds::Topic* topic(const TopicInfo& info);

  // Called from listeners: short, and nothing of DDS is called.
  void report(Mismatch mismatch);
  void report(const std::string& problem);
  void remember(const std::string& topic, const std::string& guid, Endpoint endpoint);
  void forget(const std::string& topic, const std::string& guid);

  std::string name, id, host;
  int domain = 0;
  std::uint32_t max_bytes = 0;
  bool watches_ports = false;  ///< of shared memory
  eprosima::fastdds::dds::DomainParticipant* participant = nullptr;
  std::unique_ptr<eprosima::fastdds::dds::DomainParticipantListener> listener;

  std::mutex topics_mutex;
  std::map<std::string, eprosima::fastdds::dds::Topic*, std::less<>> topics;

  mutable std::mutex problems_mutex;
  std::condition_variable problems_changed;
  std::deque<Mismatch> mismatches;
  std::deque<std::string> reports;
  std::vector<std::string> problems;
  std::vector<std::function<void(const std::string&)>> callbacks;
  std::map<std::string, std::map<std::string, Endpoint>> endpoints;  ///< by topic, then by GUID
  bool stop = false;
  std::thread reporter;

 private:
  void run_reporter();
  std::optional<std::string> in_words(const Mismatch& mismatch) const;
};

}  // namespace primo::bus
