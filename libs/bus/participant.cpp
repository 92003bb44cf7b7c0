#include "bus/participant.h"

#include <fastdds/rtps/transport/UDPv4TransportDescriptor.h>
#include <fastdds/rtps/transport/shared_mem/SharedMemTransportDescriptor.h>
#include <fastrtps/attributes/LibrarySettingsAttributes.h>
#include <fastrtps/utils/IPLocator.h>
#include <fastrtps/xmlparser/XMLProfileManager.h>
#include <spdlog/spdlog.h>
#include <sys/random.h>
#include <unistd.h>

#include <algorithm>
#include <charconv>
#include <cstdlib>
#include <fastdds/dds/domain/DomainParticipantFactory.hpp>
#include <fastdds/dds/log/Log.hpp>
#include <sstream>

#include "bus/orphaned_ports.h"
#include "bus/participant_impl.h"
#include "bus/shared_memory.h"
#include "core/hash.h"

namespace primo::bus {

namespace dds = eprosima::fastdds::dds;
namespace rtps = eprosima::fastrtps::rtps;

namespace {

using Clock = std::chrono::steady_clock;

constexpr int kPeerRange = 32;  // participant numbers of a host that named peers announce themselves to
/// A process that does nothing for this long (by default a second), ms, is taken for dead by those who write to its
/// ports of shared memory. On a busy machine that happens to the living too.
constexpr std::uint32_t kStall = 3000;
constexpr auto kPortsPeriod = std::chrono::seconds(1);

/// What Fast DDS has to say goes where our own log goes. Much of what it calls an error is a peer's sudden end.
class LogToSpdlog : public dds::LogConsumer {
 public:
  void Consume(const dds::Log::Entry& entry) override {
    spdlog::debug("Fast DDS {}: {}", entry.context.category, entry.message);
  }
};

void set_library_up() {
  static const bool once = [] {
    dds::Log::ClearConsumers();
    dds::Log::RegisterConsumer(std::make_unique<LogToSpdlog>());
    // Two participants of one process talk like those of two processes.
    eprosima::fastrtps::LibrarySettingsAttributes settings;
    settings.intraprocess_delivery = eprosima::fastrtps::INTRAPROCESS_OFF;
    eprosima::fastrtps::xmlparser::XMLProfileManager::library_settings(settings);
    return true;
  }();
  (void)once;
}

/// Remembers what discovery says of others' endpoints, for the sake of messages about mismatches.
class Discovery : public dds::DomainParticipantListener {
 public:
  explicit Discovery(Participant::Impl& impl) : impl_(impl) {}

  void on_subscriber_discovery(dds::DomainParticipant*, rtps::ReaderDiscoveryInfo&& found) override {
    note(found.info, found.status == rtps::ReaderDiscoveryInfo::REMOVED_READER, false);
  }
  void on_publisher_discovery(dds::DomainParticipant*, rtps::WriterDiscoveryInfo&& found) override {
    note(found.info, found.status == rtps::WriterDiscoveryInfo::REMOVED_WRITER, true);
  }

 private:
  template <class ProxyData>
  void note(const ProxyData& data, bool removed, bool is_writer) {
    std::ostringstream guid;
    guid << data.guid();
    const std::string topic = data.topicName().to_string();
    if (removed) {
      impl_.forget(topic, guid.str());
    } else {
      impl_.remember(topic, guid.str(), {is_writer, policies_of_remote(data.m_qos)});
    }
  }
  Participant::Impl& impl_;
};

std::string incarnation() {
  std::uint64_t bits = 0;
  if (getrandom(&bits, sizeof bits, 0) != static_cast<ssize_t>(sizeof bits)) {
    bits = Hasher()
               .add(static_cast<std::uint64_t>(getpid()))
               .add(static_cast<std::uint64_t>(Clock::now().time_since_epoch().count()))
               .value();
  }
  return hex(bits);
}

std::string host_name() {
  char buffer[256] = {};
  if (gethostname(buffer, sizeof buffer - 1) != 0) return "unknown";
  return buffer;
}

Status check(const BusSettings& settings, const std::string& name) {
  const auto allowed = [](unsigned char c) { return std::isalnum(c) != 0 || c == '_' || c == '-' || c == '.'; };
  if (name.empty() || name.size() > 64 || !std::all_of(name.begin(), name.end(), allowed)) {
    return Error{Code::config, "bus: the name '" + name + "' must be 1 to 64 letters, digits, '_', '-' or '.'"};
  }
  const auto within = [](const char* what, int value, int low, int high) -> Status {
    if (value >= low && value <= high) return success();
    return Error{Code::config, std::string("bus: ") + what + " is " + std::to_string(value) + ", expected " +
                                   std::to_string(low) + " to " + std::to_string(high)};
  };
  PRIMO_TRY(within("segment_mib", settings.segment_mib, 4, 1024));
  PRIMO_TRY(within("socket_buffer_mib", settings.socket_buffer_mib, 1, 256));
  PRIMO_TRY(within("lease_ms", settings.lease_ms, 200, 600000));
  PRIMO_TRY(within("max_sample_mib", settings.max_sample_mib, 1, 1024));
  return success();
}

/// Peers as initial addresses to announce to, beside the usual multicast group.
Status add_peers(const std::vector<std::string>& peers, rtps::BuiltinAttributes& builtin) {
  if (peers.empty()) return success();
  std::vector<std::string> addresses = {"239.255.0.1"};
  for (const std::string& peer : peers) {
    if (rtps::IPLocator::isIPv4(peer)) {
      addresses.push_back(peer);
      continue;
    }
    const auto resolved = rtps::IPLocator::resolveNameDNS(peer).first;
    if (resolved.empty()) {
      return Error{Code::config,
                   "bus: the peer '" + peer + "' is neither an IPv4 address nor a host name that resolves to one"};
    }
    addresses.push_back(*resolved.begin());
  }
  for (const std::string& address : addresses) {
    rtps::Locator_t locator;
    rtps::IPLocator::createLocator(LOCATOR_KIND_UDPv4, address, 0, locator);
    builtin.initialPeersList.push_back(locator);
  }
  return success();
}

Result<dds::DomainParticipantQos> participant_qos(const BusSettings& settings, int domain, const std::string& id) {
  dds::DomainParticipantQos qos = dds::PARTICIPANT_QOS_DEFAULT;
  qos.name(id);
  auto& builtin = qos.wire_protocol().builtin;
  const std::int64_t ns = std::int64_t{settings.lease_ms} * 1000000;
  builtin.discovery_config.leaseDuration = {static_cast<std::int32_t>(ns / 1000000000),
                                            static_cast<std::uint32_t>(ns % 1000000000)};
  builtin.discovery_config.leaseDuration_announcementperiod = {static_cast<std::int32_t>(ns / 4 / 1000000000),
                                                               static_cast<std::uint32_t>(ns / 4 % 1000000000)};
  PRIMO_TRY(add_peers(settings.peers, builtin));

  qos.transport().use_builtin_transports = false;
  if (settings.shared_memory) {
    auto shared = std::make_shared<eprosima::fastdds::rtps::SharedMemTransportDescriptor>();
    shared->healthy_check_timeout_ms(kStall);
    shared->segment_size(static_cast<std::uint32_t>(settings.segment_mib) << 20);
    qos.transport().user_transports.push_back(shared);
    // Others find this process by multicast, whatever its number; named peers try the first ones.
    const int range = settings.peers.empty() ? 120 : kPeerRange;
    int& number = qos.wire_protocol().participant_id;
    number = unused_participant_id(domain, range);
    if (number < 0 && remove_dead_shared_memory() > 0) number = unused_participant_id(domain, range);
  }
  auto udp = std::make_shared<eprosima::fastdds::rtps::UDPv4TransportDescriptor>();
  udp->sendBufferSize = static_cast<std::uint32_t>(settings.socket_buffer_mib) << 20;
  udp->receiveBufferSize = udp->sendBufferSize;
  udp->maxInitialPeersRange = kPeerRange;  // a graph has more than the default of 4 processes on a host
  qos.transport().user_transports.push_back(udp);
  return qos;
}

}  // namespace

Result<int> effective_domain(const BusSettings& settings) {
  int domain = settings.domain;
  std::string origin = "bus.domain";
  if (settings.domain_override) {
    domain = *settings.domain_override;
    origin = "--domain";
  } else if (const char* text = std::getenv("PRIMO_DOMAIN"); text != nullptr && *text != '\0') {
    origin = "PRIMO_DOMAIN";
    const std::string_view digits(text);
    const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), domain);
    if (error != std::errc() || end != digits.data() + digits.size()) {
      return Error{Code::config, "PRIMO_DOMAIN is '" + std::string(digits) + "', expected a number from 0 to 232"};
    }
  }
  if (domain < 0 || domain > 232) {
    return Error{Code::config, origin + " is " + std::to_string(domain) + ", expected 0 to 232"};
  }
  return domain;
}

Result<Participant> Participant::create(const BusSettings& settings, const std::string& name) {
  PRIMO_TRY(check(settings, name));
  PRIMO_ASSIGN(const int domain, effective_domain(settings));
  if (settings.shared_memory) PRIMO_TRY(probe_shared_memory(std::size_t(settings.segment_mib) << 20));
  set_library_up();

  auto impl = std::make_shared<Impl>();
  impl->name = name;
  impl->id = name + "-" + incarnation();
  impl->host = host_name();
  impl->domain = domain;
  impl->max_bytes = static_cast<std::uint32_t>(settings.max_sample_mib) << 20;
  impl->listener = std::make_unique<Discovery>(*impl);
  PRIMO_ASSIGN(const dds::DomainParticipantQos qos, participant_qos(settings, domain, impl->id));
  impl->participant = dds::DomainParticipantFactory::get_instance()->create_participant(
      static_cast<std::uint32_t>(domain), qos, impl->listener.get(), dds::StatusMask::none());
  if (impl->participant == nullptr) {
    return Error{Code::unavailable,
                 "bus: no DDS participant in domain " + std::to_string(domain) +
                     ": its UDP ports cannot be had; stop what holds them, or choose another domain"};
  }
  if (settings.shared_memory && !shared_memory_mapped()) {
    return Error{Code::unavailable,
                 "bus: Fast DDS could not set its shared memory up in /dev/shm; check its space and permissions, "
                 "or set bus.shared_memory: false"};
  }
  impl->watches_ports = settings.shared_memory;
  impl->start();
  return Participant(std::move(impl));
}

const std::string& Participant::name() const { return impl_->name; }
const std::string& Participant::id() const { return impl_->id; }
int Participant::domain() const { return impl_->domain; }
const std::string& Participant::host() const { return impl_->host; }

std::vector<std::string> Participant::problems() const {
  const std::lock_guard lock(impl_->problems_mutex);
  return impl_->problems;
}

void Participant::on_problem(std::function<void(const std::string&)> callback) {
  const std::lock_guard lock(impl_->problems_mutex);
  impl_->callbacks.push_back(std::move(callback));
}

Participant::Impl::~Impl() {
  {
    const std::lock_guard lock(problems_mutex);
    stop = true;
  }
  problems_changed.notify_all();
  if (reporter.joinable()) reporter.join();
  if (participant == nullptr) return;
  participant->set_listener(nullptr);
  for (const auto& [topic_name, entry] : topics) participant->delete_topic(entry);
  participant->delete_contained_entities();
  dds::DomainParticipantFactory::get_instance()->delete_participant(participant);
}

void Participant::Impl::start() {
  reporter = std::thread([this] { run_reporter(); });
}

dds::Topic* Participant::Impl::topic(const TopicInfo& info) {
  const std::lock_guard lock(topics_mutex);
  if (const auto found = topics.find(info.name); found != topics.end()) return found->second;
  dds::TypeSupport type(new GuardedType(generated_type(info), max_bytes));
  if (type.register_type(participant) != eprosima::fastrtps::types::ReturnCode_t::RETCODE_OK) return nullptr;
  dds::Topic* made = participant->create_topic(std::string(info.name), type.get_type_name(), dds::TOPIC_QOS_DEFAULT);
  if (made != nullptr) topics.emplace(info.name, made);
  return made;
}

void Participant::Impl::report(Mismatch mismatch) {
  {
    const std::lock_guard lock(problems_mutex);
    if (mismatches.size() < 1000) mismatches.push_back(std::move(mismatch));
  }
  problems_changed.notify_one();
}

void Participant::Impl::report(const std::string& problem) {
  {
    const std::lock_guard lock(problems_mutex);
    if (reports.size() < 1000) reports.push_back(problem);
  }
  problems_changed.notify_one();
}

void Participant::Impl::remember(const std::string& topic, const std::string& guid, Endpoint endpoint) {
  const std::lock_guard lock(problems_mutex);
  endpoints[topic].insert_or_assign(guid, endpoint);
}

void Participant::Impl::forget(const std::string& topic, const std::string& guid) {
  const std::lock_guard lock(problems_mutex);
  const auto found = endpoints.find(topic);
  if (found == endpoints.end()) return;
  found->second.erase(guid);
  if (found->second.empty()) endpoints.erase(found);
}

/// Once the other side is known, or the time to wait for it is over. @pre problems_mutex is held
std::optional<std::string> Participant::Impl::in_words(const Mismatch& m) const {
  const std::string head =
      "QoS mismatch on topic " + std::string(m.topic->name) + ", policy " + policy_name(m.policy) + ": ";
  const std::string ours = policy_value(m.policy, m.ours);
  const std::string tail = "; no sample will pass between them";
  if (const auto found = endpoints.find(std::string(m.topic->name)); found != endpoints.end()) {
    for (const auto& [guid, theirs] : found->second) {
      if (theirs.is_writer == m.ours_is_writer) continue;
      const Policies& offered = m.ours_is_writer ? m.ours : theirs.policies;
      const Policies& requested = m.ours_is_writer ? theirs.policies : m.ours;
      if (!mismatch(m.policy, offered, requested)) continue;
      return head +
             (m.ours_is_writer ? "the writer of " + id + " offers " + ours + ", the reader " + guid + " requests "
                               : "the reader of " + id + " requests " + ours + ", the writer " + guid + " offers ") +
             policy_value(m.policy, theirs.policies) + tail;
    }
  }
  if (Clock::now() < m.until) return std::nullopt;
  return head + (m.ours_is_writer ? "the writer of " : "the reader of ") + id +
         (m.ours_is_writer ? " offers " : " requests ") + (ours.empty() ? "another value" : ours) +
         " than another process's endpoint, which DDS doesn't describe" + tail;
}

void Participant::Impl::run_reporter() {
  OrphanedPorts orphans;
  auto look = Clock::now() + kPortsPeriod;
  std::unique_lock lock(problems_mutex);
  while (!stop) {
    if (watches_ports && Clock::now() >= look) {
      lock.unlock();
      for (const int port : orphans.mark()) {
        spdlog::info("shared-memory port {} was removed or replaced by another process; it is opened anew", port);
      }
      look = Clock::now() + kPortsPeriod;
      lock.lock();
    }
    std::vector<std::string> said(reports.begin(), reports.end());
    reports.clear();
    for (std::size_t left = mismatches.size(); left > 0; --left) {
      Mismatch mismatch = std::move(mismatches.front());
      mismatches.pop_front();
      if (auto words = in_words(mismatch)) {
        said.push_back(std::move(*words));
      } else {
        mismatches.push_back(std::move(mismatch));
      }
    }
    std::erase_if(said, [&](const std::string& text) {
      return std::find(problems.begin(), problems.end(), text) != problems.end();
    });
    if (problems.size() < 1000) problems.insert(problems.end(), said.begin(), said.end());
    const auto listeners = callbacks;
    lock.unlock();
    for (const std::string& text : said) {
      spdlog::warn("{}", text);
      for (const auto& callback : listeners) callback(text);
    }
    lock.lock();
    if (stop) break;
    if (!mismatches.empty()) {
      problems_changed.wait_for(lock, std::chrono::milliseconds(50));
    } else {
      const auto has_news = [&] { return stop || !mismatches.empty() || !reports.empty(); };
      if (watches_ports) {
        problems_changed.wait_until(lock, look, has_news);
      } else {
        problems_changed.wait(lock, has_news);
      }
    }
  }
}

}  // namespace primo::bus
