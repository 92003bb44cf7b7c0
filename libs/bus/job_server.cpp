#include "bus/job_server.h"

#include <spdlog/spdlog.h>

#include <algorithm>
#include <condition_variable>
#include <deque>
#include <map>
#include <mutex>
#include <thread>

#include "bus/endpoint.h"

namespace primo::bus {
namespace {

using Clock = std::chrono::steady_clock;
using primo_msgs::msg::JobHeader;
using primo_msgs::msg::ReplyHeader;

/// Names that may become a partition: nothing that DDS would take for a pattern.
bool is_requester(const std::string& name) {
  return !name.empty() && name.size() <= 200 && std::all_of(name.begin(), name.end(), [](unsigned char c) {
    return std::isalnum(c) != 0 || c == '_' || c == '-' || c == '.';
  });
}

}  // namespace

struct ServerCore::Impl {
  struct Requester {
    std::shared_ptr<Writer> writer;
    Clock::time_point made, used;
  };

  Impl(Participant participant_in, StatusPublisher& status_in, const Types& types_in)
      : participant(std::move(participant_in)), status(status_in), types(types_in) {}
  ~Impl();

  void on_request(void* sample);
  std::shared_ptr<Writer> writer_for(const std::string& requester);
  void work();
  void handle(const void* request);
  void refuse(const JobHeader& head, const std::string& why);
  void answer(const std::string& requester, void* reply);
  void drop_absent_requesters();

  Participant participant;
  StatusPublisher& status;
  Types types;
  Handler handler;
  ServerSettings settings;
  const TopicInfo* reply_topic = nullptr;

  std::mutex mutex;
  std::condition_variable changed;
  std::deque<std::shared_ptr<void>> queue;
  std::map<std::string, Requester> requesters;
  bool draining = false, working = false, stop = false;
  std::unique_ptr<Reader> reader;
  std::thread thread;
};

ServerCore::Impl::~Impl() {
  reader.reset();
  {
    const std::lock_guard lock(mutex);
    stop = true;
  }
  changed.notify_all();
  if (thread.joinable()) thread.join();
}

void ServerCore::Impl::on_request(void* sample) {
  const JobHeader head = types.request_head(sample);
  if (!is_requester(head.requester()) || head.id().empty() || head.id().size() > 200) {
    spdlog::warn("a job without a usable requester or id is dropped (requester '{:.64}')", head.requester());
    return;
  }
  // Made now, so that its reader finds it while the job is worked on.
  if (writer_for(head.requester()) == nullptr) return;
  std::string refusal;
  {
    const std::lock_guard lock(mutex);
    if (draining) {
      refusal = "is shutting down";
    } else if (static_cast<int>(queue.size()) >= settings.queue) {
      refusal = "has " + std::to_string(queue.size()) + " jobs waiting and takes no more";
    } else {
      queue.push_back(types.steal_request(sample));
    }
  }
  if (refusal.empty()) {
    changed.notify_all();
  } else {
    refuse(head, refusal);
  }
}

std::shared_ptr<Writer> ServerCore::Impl::writer_for(const std::string& requester) {
  {
    const std::lock_guard lock(mutex);
    if (const auto found = requesters.find(requester); found != requesters.end()) return found->second.writer;
  }
  EndpointOptions options;
  options.partition = requester;
  auto writer = Writer::create(participant, *reply_topic, types.reply, std::move(options));
  if (!writer.ok()) {
    spdlog::error("replies to {}: {}", requester, writer.error().message);
    return nullptr;
  }
  const std::lock_guard lock(mutex);
  const auto now = Clock::now();
  return requesters.try_emplace(requester, Requester{std::move(writer).value(), now, now}).first->second.writer;
}

void ServerCore::Impl::refuse(const JobHeader& head, const std::string& why) {
  const auto reply = types.new_reply();
  ReplyHeader& out = types.reply_head(reply.get());
  out.id(head.id());
  out.attempt(head.attempt());
  out.worker(participant.id());
  out.ok(false);
  out.code(static_cast<std::uint8_t>(Code::unavailable));
  out.message(why);
  answer(head.requester(), reply.get());
}

void ServerCore::Impl::work() {
  while (true) {
    std::shared_ptr<void> request;
    {
      std::unique_lock lock(mutex);
      working = false;
      changed.notify_all();
      const bool timed_out = !changed.wait_for(lock, std::chrono::seconds(5), [&] { return stop || !queue.empty(); });
      if (stop) return;
      if (!timed_out) {
        request = std::move(queue.front());
        queue.pop_front();
        working = true;
      }
    }
    if (request == nullptr) {
      drop_absent_requesters();
    } else {
      handle(request.get());
    }
  }
}

void ServerCore::Impl::handle(const void* request) {
  const JobHeader& head = types.request_head(request);
  const auto reply = types.new_reply();
  status.job_started();
  const auto begin = Clock::now();
  Status done = success();
  try {
    done = handler(request, reply.get());
  } catch (const std::exception& e) {
    done = Error{Code::internal, std::string("the handler threw: ") + e.what()};
  }
  const double seconds = std::chrono::duration<double>(Clock::now() - begin).count();
  ReplyHeader out;
  out.id(head.id());
  out.attempt(head.attempt());
  out.worker(participant.id());
  out.seconds(seconds);
  out.ok(done.ok());
  if (!done.ok()) {
    out.code(static_cast<std::uint8_t>(done.error().code));
    out.message(done.error().message);
    spdlog::warn("job {} of {}: {}", head.id(), head.requester(), done.error().message);
  }
  types.reply_head(reply.get()) = std::move(out);
  status.job_finished(done.ok(), done.ok() ? "" : done.error().message);
  answer(head.requester(), reply.get());
}

void ServerCore::Impl::answer(const std::string& requester, void* reply) {
  std::shared_ptr<Writer> writer;
  Clock::time_point made;
  {
    const std::lock_guard lock(mutex);
    const auto found = requesters.find(requester);
    if (found == requesters.end()) return;
    writer = found->second.writer;
    made = found->second.made;
    found->second.used = Clock::now();
  }
  // A new requester's reader may take a moment to be found; one that has gone isn't waited for.
  if (writer->matched() == 0) {
    const auto left =
        std::chrono::duration_cast<std::chrono::milliseconds>(made + std::chrono::seconds(2) - Clock::now());
    if (writer->was_matched() || left.count() <= 0 || !writer->wait_matched(1, left)) {
      spdlog::info("{} is gone; its answer is dropped", requester);
      return;
    }
  }
  if (const Status written = writer->write(reply); !written.ok()) {
    spdlog::warn("the answer to {} is lost: {}", requester, written.error().message);
    status.set_error(written.error().message);
    if (written.error().code != Code::data) return;
    // An answer that can't be sent is an answer too: without it the requester would try again and again.
    ReplyHeader head = types.reply_head(reply);
    head.ok(false);
    head.code(static_cast<std::uint8_t>(Code::data));
    head.message("the answer can't be sent: " + written.error().message);
    const auto error_reply = types.new_reply();
    types.reply_head(error_reply.get()) = std::move(head);
    (void)writer->write(error_reply.get());
  }
}

void ServerCore::Impl::drop_absent_requesters() {
  std::vector<std::shared_ptr<Writer>> dropped;  // destroyed without the lock
  const std::lock_guard lock(mutex);
  const auto now = Clock::now();
  std::erase_if(requesters, [&](auto& entry) {
    const bool absent = entry.second.writer->matched() == 0 && now - entry.second.used > std::chrono::seconds(10) &&
                        now - entry.second.made > std::chrono::seconds(10);
    if (absent) dropped.push_back(std::move(entry.second.writer));
    return absent;
  });
}

ServerCore::ServerCore(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
ServerCore::~ServerCore() = default;

Result<std::unique_ptr<ServerCore>> ServerCore::create(const Participant& participant, StatusPublisher& status,
                                                       const TopicInfo& request, const TopicInfo& reply,
                                                       const Types& types, Handler handler,
                                                       const ServerSettings& settings) {
  if (settings.credits < 1 || settings.queue < 1) {
    return Error{Code::config, "a job server's credits and queue must be at least 1"};
  }
  auto impl = std::make_unique<Impl>(participant, status, types);
  impl->handler = std::move(handler);
  impl->settings = settings;
  impl->reply_topic = &reply;
  EndpointOptions options;
  options.partition = participant.id();
  ReaderCallbacks callbacks;
  callbacks.on_sample = [raw = impl.get()](void* sample, const Origin&) { raw->on_request(sample); };
  PRIMO_ASSIGN(impl->reader,
               Reader::create(participant, request, types.request, std::move(callbacks), std::move(options)));
  impl->thread = std::thread([raw = impl.get()] { raw->work(); });
  status.set_credits(settings.credits);
  status.waiting_for("");
  status.set_state(State::idle);
  return std::unique_ptr<ServerCore>(new ServerCore(std::move(impl)));
}

bool ServerCore::drain(std::chrono::milliseconds timeout) {
  impl_->status.set_state(State::draining);
  std::deque<std::shared_ptr<void>> handed_back;
  {
    const std::lock_guard lock(impl_->mutex);
    impl_->draining = true;
    handed_back.swap(impl_->queue);
  }
  for (const auto& request : handed_back) impl_->refuse(impl_->types.request_head(request.get()), "is shutting down");
  std::vector<std::shared_ptr<Writer>> writers;
  {
    std::unique_lock lock(impl_->mutex);
    if (!impl_->changed.wait_for(lock, timeout, [&] { return !impl_->working; })) return false;
    for (const auto& [name, requester] : impl_->requesters) writers.push_back(requester.writer);
  }
  for (const auto& writer : writers) {
    if (writer->matched() > 0) (void)writer->wait_acknowledged(std::chrono::seconds(1));
  }
  return true;
}

}  // namespace primo::bus
