#include "bus/job_client.h"

#include <spdlog/spdlog.h>

#include <atomic>
#include <charconv>
#include <condition_variable>
#include <map>
#include <mutex>
#include <thread>
#include <vector>

#include "bus/dispatch.h"
#include "bus/endpoint.h"

namespace primo::bus {
namespace {

using Clock = std::chrono::steady_clock;
using primo_msgs::msg::ReplyHeader;

/// Job ids are unique in the process, so that several clients of one kind can share its partition.
std::uint64_t next_id() {
  static std::atomic<std::uint64_t> last{0};
  return ++last;
}

std::optional<std::uint64_t> number(const std::string& text) {
  std::uint64_t value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size()) return std::nullopt;
  return value;
}

Error error_of(const ReplyHeader& head) {
  const Code code =
      head.code() <= static_cast<std::uint8_t>(Code::internal) ? static_cast<Code>(head.code()) : Code::internal;
  return {code, head.worker() + ": " + head.message()};
}

}  // namespace

// Two locks. `mutex` guards the table and is held while requests are written, so no listener of DDS may take it; what
// listeners have to say goes through `wake`, which is held for a moment only.
struct ClientCore::Impl {
  struct Job {
    std::shared_ptr<void> request;
    Completion completion;
  };
  struct Worker {
    std::shared_ptr<Writer> writer;
    unsigned credits = 0;
    bool announced = false;  ///< in the table: its reader and our writer have found each other
  };

  Impl(std::string_view role_name, const Types& types_in, Mailbox& mailbox_in, const ClientSettings& settings_in)
      : role(role_name),
        types(types_in),
        mailbox(mailbox_in),
        settings(settings_in),
        table(role, settings_in.deadline, settings_in.attempts) {}
  ~Impl();

  void on_worker(WorkerEvent event, const WorkerInfo& info);
  void on_reply(void* sample);
  void run();
  void step();
  void send(const DispatchTable::Assignment& assignment, Clock::time_point now);
  void complete(std::uint64_t id, Result<std::shared_ptr<void>> result);
  void say_waiting();
  void wake_up();

  std::string role, self;
  Types types;
  Mailbox& mailbox;
  ClientSettings settings;
  std::optional<Participant> participant;
  const TopicInfo* request_topic = nullptr;
  StatusWatcher* watcher = nullptr;
  int subscription = 0;

  mutable std::mutex mutex;
  DispatchTable table;
  std::map<std::uint64_t, Job> jobs;
  std::map<std::string, Worker> workers;
  ClientCounters counts;
  std::function<void(const std::string&)> waiting_callback;
  std::string waiting_said;

  Clock::time_point sleeps_until{};  ///< the thread; step() is not called by it earlier

  std::mutex wake;
  std::condition_variable woken;
  bool pending_wake = false, stop = false;
  std::thread thread;
  std::unique_ptr<Reader> reader;
};

ClientCore::Impl::~Impl() {
  if (watcher != nullptr) watcher->cancel(subscription);
  reader.reset();
  {
    const std::lock_guard lock(wake);
    stop = true;
  }
  woken.notify_all();
  if (thread.joinable()) thread.join();
}

void ClientCore::Impl::wake_up() {
  {
    const std::lock_guard lock(wake);
    pending_wake = true;
  }
  woken.notify_one();
}

void ClientCore::Impl::on_worker(WorkerEvent event, const WorkerInfo& info) {
  if (info.role != role) return;
  const bool gone = event == WorkerEvent::died;
  const unsigned credits = info.state == State::draining ? 0 : info.credits;
  std::shared_ptr<Writer> made, unused;
  bool known = false;
  {
    const std::lock_guard lock(mutex);
    known = workers.contains(info.worker);
  }
  if (!gone && !known && credits > 0) {
    // Made without our lock: DDS calls listeners while it makes a writer.
    EndpointOptions options;
    options.partition = info.worker;
    auto writer =
        Writer::create(*participant, *request_topic, types.request, std::move(options), [this] { wake_up(); });
    if (!writer.ok()) {
      spdlog::error("{} {}: {}", role, info.worker, writer.error().message);
      return;
    }
    made = std::move(writer).value();
  }
  {
    const std::lock_guard lock(mutex);
    if (gone) {
      const auto found = workers.find(info.worker);
      if (found == workers.end()) return;
      unused = std::move(found->second.writer);
      workers.erase(found);
      table.remove_worker(info.worker);
    } else if (made != nullptr || known) {
      Worker& worker = workers[info.worker];
      if (made != nullptr) worker.writer = std::move(made);
      worker.credits = credits;
      worker.announced = false;  // step() announces it with its present credits
    }
  }
  wake_up();
}

void ClientCore::Impl::on_reply(void* sample) {
  const ReplyHeader head = types.reply_head(sample);
  const auto id = number(head.id());
  if (!id) {
    spdlog::warn("{}: a reply of {} to the unknown job '{}' is dropped", role, head.worker(), head.id());
    return;
  }
  const std::lock_guard lock(mutex);
  const bool give_back = !head.ok() && head.code() == static_cast<std::uint8_t>(Code::unavailable);
  if (give_back) {
    spdlog::debug("{} {} hands job {} back: {}", role, head.worker(), *id, head.message());
    table.returned(*id, head.worker(), Clock::now());
    step();
    wake_up();
    return;
  }
  if (!table.answered(*id, head.worker())) {
    ++counts.dropped;
  } else if (head.ok()) {
    complete(*id, types.steal_reply(sample));
  } else {
    complete(*id, error_of(head));
  }
  step();
}

/// @pre mutex is held
void ClientCore::Impl::complete(std::uint64_t id, Result<std::shared_ptr<void>> result) {
  const auto found = jobs.find(id);
  if (found == jobs.end()) return;
  ++(result.ok() ? counts.completed : counts.failed);
  mailbox.post([completion = std::move(found->second.completion), answer = std::move(result)]() mutable {
    completion(std::move(answer));
  });
  jobs.erase(found);
}

/// Everything that can be done now. @pre mutex is held
void ClientCore::Impl::step() {
  const auto now = Clock::now();
  for (auto& [name, worker] : workers) {
    if (worker.announced || worker.writer->matched() == 0) continue;
    worker.announced = true;
    table.set_worker(name, worker.credits);
  }
  table.expire(now);
  for (const DispatchTable::Assignment& assignment : table.assign(now)) send(assignment, now);
  for (DispatchTable::Failure& failure : table.take_failures()) {
    complete(failure.job, Error{Code::unavailable, std::move(failure.message)});
  }
  say_waiting();
}

void ClientCore::Impl::send(const DispatchTable::Assignment& assignment, Clock::time_point now) {
  const auto job = jobs.find(assignment.job);
  const auto worker = workers.find(assignment.worker);
  if (job == jobs.end() || worker == workers.end()) {
    table.returned(assignment.job, assignment.worker, now);
    return;
  }
  auto& head = types.request_head(job->second.request.get());
  head.attempt(assignment.attempt);
  const Status written = worker->second.writer->write(job->second.request.get());
  if (written.ok()) {
    ++counts.sent;
    if (assignment.attempt > 1) {
      ++counts.reissued;
      spdlog::info("{} job {} goes to {} as attempt {}", role, assignment.job, assignment.worker, assignment.attempt);
    }
    return;
  }
  if (written.error().code == Code::data) {
    table.answered(assignment.job, assignment.worker);
    complete(assignment.job, written.error());
    return;
  }
  spdlog::warn("{} {}: {}", role, assignment.worker, written.error().message);
  table.returned(assignment.job, assignment.worker, now);
}

void ClientCore::Impl::say_waiting() {
  std::string text;
  if (table.waiting() > 0 && table.window() == 0) {
    text = std::string(role.find_first_of("aeiou") == 0 ? "an " : "a ") + role +
           (workers.empty() ? " (none is up)" : " (none takes jobs)");
  }
  if (text == waiting_said) return;
  waiting_said = text;
  if (waiting_callback) waiting_callback(text);
}

void ClientCore::Impl::run() {
  while (true) {
    std::optional<Clock::time_point> next;
    {
      const std::lock_guard lock(mutex);
      step();
      next = table.next_time();
      sleeps_until = next.value_or(Clock::time_point::max());
    }
    std::unique_lock lock(wake);
    const auto has_news = [&] { return pending_wake || stop; };
    if (next) {
      woken.wait_until(lock, *next, has_news);
    } else {
      woken.wait(lock, has_news);
    }
    if (stop) return;
    pending_wake = false;
  }
}

ClientCore::ClientCore(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
ClientCore::~ClientCore() = default;

Result<std::unique_ptr<ClientCore>> ClientCore::create(const Participant& participant, StatusWatcher& watcher,
                                                       std::string_view role, const TopicInfo& request,
                                                       const TopicInfo& reply, const Types& types, Mailbox& mailbox,
                                                       const ClientSettings& settings) {
  if (settings.deadline <= std::chrono::milliseconds(0) || settings.attempts < 1 || settings.queue < 1) {
    return Error{Code::config, "jobs for a " + std::string(role) + ": deadline, attempts and queue must be positive"};
  }
  auto impl = std::make_unique<Impl>(role, types, mailbox, settings);
  impl->participant = participant;
  impl->self = participant.id();
  impl->request_topic = &request;
  EndpointOptions options;
  options.partition = participant.id();
  ReaderCallbacks callbacks;
  callbacks.on_sample = [raw = impl.get()](void* sample, const Origin&) { raw->on_reply(sample); };
  PRIMO_ASSIGN(impl->reader, Reader::create(participant, reply, types.reply, std::move(callbacks), std::move(options)));
  impl->thread = std::thread([raw = impl.get()] { raw->run(); });
  impl->subscription = watcher.subscribe(
      [raw = impl.get()](WorkerEvent event, const WorkerInfo& worker) { raw->on_worker(event, worker); });
  impl->watcher = &watcher;
  return std::unique_ptr<ClientCore>(new ClientCore(std::move(impl)));
}

Result<std::string> ClientCore::submit(std::shared_ptr<void> request, Completion completion) {
  const std::lock_guard lock(impl_->mutex);
  if (static_cast<int>(impl_->jobs.size()) >= impl_->settings.queue) {
    return Error{Code::unavailable, "jobs for a " + impl_->role + ": " + std::to_string(impl_->jobs.size()) +
                                        " are unanswered, and no more are taken"};
  }
  const std::uint64_t id = next_id();
  auto& head = impl_->types.request_head(request.get());
  head.id(std::to_string(id));
  head.requester(impl_->self);
  head.deadline_ms(static_cast<std::uint32_t>(impl_->settings.deadline.count()));
  impl_->jobs.emplace(id, Impl::Job{std::move(request), std::move(completion)});
  impl_->table.add(id);
  ++impl_->counts.submitted;
  impl_->step();
  // The thread is for what time brings. It need not wake for a job whose deadline comes after those it waits for.
  if (const auto next = impl_->table.next_time(); next && *next < impl_->sleeps_until) impl_->wake_up();
  return std::to_string(id);
}

void ClientCore::on_waiting(std::function<void(const std::string&)> callback) {
  const std::lock_guard lock(impl_->mutex);
  impl_->waiting_callback = std::move(callback);
  if (impl_->waiting_callback && !impl_->waiting_said.empty()) impl_->waiting_callback(impl_->waiting_said);
}

int ClientCore::pending() const {
  const std::lock_guard lock(impl_->mutex);
  return static_cast<int>(impl_->jobs.size());
}

unsigned ClientCore::window() const {
  const std::lock_guard lock(impl_->mutex);
  return impl_->table.window();
}

void ClientCore::cancel_all() {
  const std::lock_guard lock(impl_->mutex);
  impl_->jobs.clear();
  impl_->table.clear();
}

ClientCounters ClientCore::counters() const {
  const std::lock_guard lock(impl_->mutex);
  return impl_->counts;
}

}  // namespace primo::bus
