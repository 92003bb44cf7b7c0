#include "bus/status.h"

#include <primo_status.h>
#include <unistd.h>

#include <algorithm>
#include <condition_variable>
#include <deque>
#include <map>
#include <mutex>
#include <optional>
#include <thread>
#include <tuple>
#include <utility>

#include "bus/endpoint.h"

namespace primo::bus {
namespace {

using Clock = std::chrono::steady_clock;
using Message = primo_msgs::msg::WorkerStatus;

constexpr auto kRateWindow = std::chrono::seconds(5);
/// What only counts is published so often; between, the heartbeat is enough.
constexpr auto kCountsPeriod = std::chrono::seconds(1);

Message to_message(const WorkerInfo& info) {
  Message message;
  message.worker(info.worker);
  message.name(info.name);
  message.role(info.role);
  message.host(info.host);
  message.pid(info.pid);
  message.state(static_cast<std::uint8_t>(info.state));
  message.waiting_for(info.waiting_for);
  message.credits(info.credits);
  message.jobs_done(info.jobs_done);
  message.jobs_failed(info.jobs_failed);
  message.jobs_per_second(info.jobs_per_second);
  message.last_error(info.last_error);
  message.config_hash(info.config_hash);
  message.version(info.version);
  return message;
}

/// Empty for a message that no status publisher of ours can have sent.
std::optional<WorkerInfo> from_message(const Message& message) {
  if (message.worker().empty() || message.worker().size() > 255 || message.role().size() > 255 || message.state() > 4 ||
      message.credits() > 1024) {
    return std::nullopt;
  }
  WorkerInfo info;
  info.worker = message.worker();
  info.name = message.name();
  info.role = message.role();
  info.host = message.host();
  info.pid = message.pid();
  info.state = static_cast<State>(message.state());
  info.waiting_for = message.waiting_for();
  info.credits = message.credits();
  info.jobs_done = message.jobs_done();
  info.jobs_failed = message.jobs_failed();
  info.jobs_per_second = std::isfinite(message.jobs_per_second()) ? message.jobs_per_second() : 0;
  info.last_error = message.last_error();
  info.config_hash = message.config_hash();
  info.version = message.version();
  return info;
}

/// What fits a status line and a key.
std::string shortened(const std::string& text, std::size_t length = 500) {
  return text.size() <= length ? text : text.substr(0, length) + "…";
}

}  // namespace

// ---- StatusPublisher

struct StatusPublisher::Impl {
  void run();
  void publish_now();
  void update_rate();

  std::unique_ptr<Writer> writer;
  std::chrono::milliseconds lease{500}, membership{10000};
  std::function<void(const std::string&)> on_lost;
  mutable std::mutex mutex;
  std::condition_variable changed;
  WorkerInfo info;
  int in_work = 0;
  std::deque<std::pair<Clock::time_point, std::uint64_t>> finished;  ///< for the rate
  bool dirty = true;                                                 ///< what is said differs from what was published
  bool urgent = true;                                                ///< to be published now
  bool beat = false;                                                 ///< time for a heartbeat
  bool stop = false;
  std::thread thread;
};

void StatusPublisher::Impl::update_rate() {
  const auto now = Clock::now();
  finished.emplace_back(now, info.jobs_done + info.jobs_failed);
  while (finished.size() > 2 && now - finished.front().first > kRateWindow) finished.pop_front();
  const double seconds = std::chrono::duration<double>(now - finished.front().first).count();
  const double rate =
      seconds > 0 ? static_cast<double>(finished.back().second - finished.front().second) / seconds : 0.0;
  if (rate != info.jobs_per_second) dirty = true;
  info.jobs_per_second = rate;
}

void StatusPublisher::Impl::run() {
  std::unique_lock lock(mutex);
  auto next = Clock::now(), last = next, published = next - kCountsPeriod;
  while (!stop) {
    const auto now = Clock::now();
    const auto gap = std::chrono::duration_cast<std::chrono::milliseconds>(now - std::exchange(last, now));
    if (gap > membership && on_lost) {
      lock.unlock();
      on_lost("was stopped for " + std::to_string(gap.count()) +
              " ms, longer than bus.lease_ms; the others have forgotten this process");
      lock.lock();
    }
    if (now >= next) {
      next = now + lease / 3;
      if (now - published >= kCountsPeriod) {
        update_rate();
        urgent = dirty;
      }
      beat = true;
    }
    if (urgent || beat) {
      const bool publish = urgent;
      if (publish) {
        dirty = false;
        published = now;
      }
      urgent = beat = false;
      const Message message = to_message(info);
      lock.unlock();
      // A failure shows itself: others take this process for dead.
      if (!publish || !writer->write(&message).ok()) (void)writer->assert_liveliness();
      lock.lock();
    }
    changed.wait_until(lock, next, [&] { return stop || urgent; });
  }
}

StatusPublisher::StatusPublisher(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}

StatusPublisher::~StatusPublisher() {
  {
    const std::lock_guard lock(impl_->mutex);
    impl_->stop = true;
  }
  impl_->changed.notify_all();
  impl_->thread.join();
}

Result<std::unique_ptr<StatusPublisher>> StatusPublisher::create(const Participant& participant,
                                                                 StatusSettings settings) {
  auto impl = std::make_unique<Impl>();
  EndpointOptions options;
  options.lease = settings.lease;
  PRIMO_ASSIGN(impl->writer, Writer::create(participant, topic_info(topics::kWorkerStatus.name), typeid(Message),
                                            std::move(options)));
  impl->lease = settings.lease;
  impl->membership = settings.membership;
  impl->on_lost = std::move(settings.on_lost);
  impl->info.worker = participant.id();
  impl->info.name = participant.name();
  impl->info.host = participant.host();
  impl->info.pid = getpid();
  impl->info.role = settings.role;
  impl->info.credits = settings.credits;
  impl->info.config_hash = settings.config_hash;
  impl->info.version = settings.version;
  impl->thread = std::thread([raw = impl.get()] { raw->run(); });
  return std::unique_ptr<StatusPublisher>(new StatusPublisher(std::move(impl)));
}

void StatusPublisher::set_state(State state) {
  {
    const std::lock_guard lock(impl_->mutex);
    impl_->info.state = state;
    impl_->dirty = impl_->urgent = true;
  }
  impl_->changed.notify_all();
}

void StatusPublisher::waiting_for(const std::string& text) {
  {
    const std::lock_guard lock(impl_->mutex);
    auto& info = impl_->info;
    if (info.waiting_for == text && (text.empty() || info.state == State::waiting)) return;
    info.waiting_for = shortened(text);
    if (info.state != State::draining) {
      info.state = !text.empty() ? State::waiting : impl_->in_work > 0 ? State::busy : State::idle;
    }
    impl_->dirty = impl_->urgent = true;
  }
  impl_->changed.notify_all();
}

void StatusPublisher::set_credits(unsigned credits) {
  {
    const std::lock_guard lock(impl_->mutex);
    impl_->info.credits = credits;
    impl_->dirty = impl_->urgent = true;
  }
  impl_->changed.notify_all();
}

void StatusPublisher::job_started() {
  const std::lock_guard lock(impl_->mutex);
  ++impl_->in_work;
  if (impl_->info.state == State::idle || impl_->info.state == State::starting) impl_->info.state = State::busy;
  impl_->dirty = true;
}

void StatusPublisher::job_finished(bool ok, const std::string& error) {
  const std::lock_guard lock(impl_->mutex);
  --impl_->in_work;
  ++(ok ? impl_->info.jobs_done : impl_->info.jobs_failed);
  if (!ok) impl_->info.last_error = shortened(error);
  if (impl_->in_work == 0 && impl_->info.state == State::busy) impl_->info.state = State::idle;
  impl_->dirty = true;
}

void StatusPublisher::set_error(const std::string& text) {
  {
    const std::lock_guard lock(impl_->mutex);
    impl_->info.last_error = shortened(text);
    impl_->dirty = impl_->urgent = true;
  }
  impl_->changed.notify_all();
}

WorkerInfo StatusPublisher::info() const {
  const std::lock_guard lock(impl_->mutex);
  return impl_->info;
}

std::chrono::milliseconds StatusPublisher::lease() const { return impl_->lease; }

// ---- StatusWatcher

struct StatusWatcher::Impl {
  struct Known {
    WorkerInfo info;
    bool alive = false;
  };

  void on_sample(const Message& message, const Origin& origin);
  void on_writer(const Origin& origin, bool alive);
  void tell(WorkerEvent event, const WorkerInfo& worker, std::unique_lock<std::mutex>& lock);

  mutable std::mutex mutex;
  mutable std::condition_variable changed;
  std::map<Origin, Known> known;
  /// Held while callbacks run, so that events stay in order and cancel() can wait. Recursive: a callback may cancel
  /// itself.
  std::recursive_mutex calling;
  std::map<int, Callback> callbacks;
  int next = 1;
  std::unique_ptr<Reader> reader;  ///< last: its thread uses the rest
};

void StatusWatcher::Impl::on_sample(const Message& message, const Origin& origin) {
  const auto info = from_message(message);
  if (!info) return;
  const std::lock_guard in_order(calling);
  std::unique_lock lock(mutex);
  const auto [entry, added] = known.try_emplace(origin);
  const bool joined = added || !entry->second.alive;
  entry->second = {*info, true};
  tell(joined ? WorkerEvent::joined : WorkerEvent::updated, *info, lock);
}

void StatusWatcher::Impl::on_writer(const Origin& origin, bool alive) {
  const std::lock_guard in_order(calling);
  std::unique_lock lock(mutex);
  const auto found = known.find(origin);
  // Who becomes alive for the first time is known by its first sample.
  if (found == known.end() || found->second.alive == alive) return;
  found->second.alive = alive;
  tell(alive ? WorkerEvent::joined : WorkerEvent::died, WorkerInfo(found->second.info), lock);
  // The dead are remembered only because a stopped process may come back; not for ever.
  constexpr std::size_t kRemembered = 1000;
  if (known.size() > kRemembered) std::erase_if(known, [](const auto& entry) { return !entry.second.alive; });
}

void StatusWatcher::Impl::tell(WorkerEvent event, const WorkerInfo& worker, std::unique_lock<std::mutex>& lock) {
  const auto listeners = callbacks;
  lock.unlock();
  changed.notify_all();
  for (const auto& [id, callback] : listeners) {
    lock.lock();
    const bool wanted = callbacks.contains(id);
    lock.unlock();
    if (wanted) callback(event, worker);
  }
  lock.lock();
}

StatusWatcher::StatusWatcher(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
StatusWatcher::~StatusWatcher() { impl_->reader.reset(); }

Result<std::unique_ptr<StatusWatcher>> StatusWatcher::create(const Participant& participant,
                                                             std::chrono::milliseconds lease) {
  auto impl = std::make_unique<Impl>();
  ReaderCallbacks callbacks;
  callbacks.on_sample = [raw = impl.get()](void* sample, const Origin& origin) {
    raw->on_sample(*static_cast<const Message*>(sample), origin);
  };
  callbacks.on_writer = [raw = impl.get()](const Origin& origin, bool alive) { raw->on_writer(origin, alive); };
  EndpointOptions options;
  options.lease = lease;
  PRIMO_ASSIGN(impl->reader, Reader::create(participant, topic_info(topics::kWorkerStatus.name), typeid(Message),
                                            std::move(callbacks), std::move(options)));
  return std::unique_ptr<StatusWatcher>(new StatusWatcher(std::move(impl)));
}

std::vector<WorkerInfo> StatusWatcher::workers() const {
  std::vector<WorkerInfo> all;
  {
    const std::lock_guard lock(impl_->mutex);
    for (const auto& [origin, entry] : impl_->known) {
      if (entry.alive) all.push_back(entry.info);
    }
  }
  std::sort(all.begin(), all.end(), [](const WorkerInfo& a, const WorkerInfo& b) {
    return std::tie(a.role, a.name, a.worker) < std::tie(b.role, b.name, b.worker);
  });
  return all;
}

std::vector<WorkerInfo> StatusWatcher::workers(const std::string& role) const {
  auto all = workers();
  std::erase_if(all, [&](const WorkerInfo& worker) { return worker.role != role; });
  return all;
}

bool StatusWatcher::wait_for(const std::string& role, int count, std::chrono::milliseconds timeout) const {
  std::unique_lock lock(impl_->mutex);
  return impl_->changed.wait_for(lock, timeout, [&] {
    return count <= std::count_if(impl_->known.begin(), impl_->known.end(), [&](const auto& entry) {
             const Impl::Known& known = entry.second;
             return known.alive && known.info.role == role && known.info.state != State::draining;
           });
  });
}

int StatusWatcher::subscribe(Callback callback) {
  const std::lock_guard in_order(impl_->calling);
  std::vector<WorkerInfo> present;
  int id = 0;
  {
    const std::lock_guard lock(impl_->mutex);
    id = impl_->next++;
    impl_->callbacks.emplace(id, callback);
    for (const auto& [origin, entry] : impl_->known) {
      if (entry.alive) present.push_back(entry.info);
    }
  }
  for (const WorkerInfo& worker : present) callback(WorkerEvent::joined, worker);
  return id;
}

void StatusWatcher::cancel(int subscription) {
  const std::lock_guard in_order(impl_->calling);
  const std::lock_guard lock(impl_->mutex);
  impl_->callbacks.erase(subscription);
}

}  // namespace primo::bus
