// Sending jobs to workers and getting each answered once, whatever dies in between.
//
// Workers are found by their status. Each has a window of credits; a job goes to a live worker with a free one. When a
// worker dies or a job's deadline passes, the job goes to another worker (the same one when there is no other); the
// first answer counts, later ones are dropped. A worker that let a deadline pass gets its credit back only with its
// answer.
#pragma once

#include <primo_common.h>

#include <chrono>
#include <functional>
#include <memory>
#include <string>
#include <typeindex>
#include <typeinfo>
#include <utility>

#include "bus/mailbox.h"
#include "bus/participant.h"
#include "bus/status.h"
#include "bus/topics.h"

namespace primo::bus {

struct ClientSettings {
  std::chrono::milliseconds deadline{20000};  ///< of one attempt
  int attempts = 5;                           ///< of one job, until it counts as failed
  int queue = 100000;                         ///< jobs submitted and unanswered at most
};

struct ClientCounters {
  std::uint64_t submitted = 0, completed = 0, failed = 0;
  std::uint64_t sent = 0;      ///< attempts
  std::uint64_t reissued = 0;  ///< attempts after the first
  std::uint64_t dropped = 0;   ///< late and doubled answers
};

/// The untyped client. See JobClient.
class ClientCore {
 public:
  struct Types {
    std::type_index request, reply;
    primo_msgs::msg::JobHeader& (*request_head)(void*);
    const primo_msgs::msg::ReplyHeader& (*reply_head)(const void*);
    std::shared_ptr<void> (*steal_reply)(void*);  ///< moves a received sample into one of its own
  };
  using Completion = std::function<void(Result<std::shared_ptr<void>>)>;

  static Result<std::unique_ptr<ClientCore>> create(const Participant& participant, StatusWatcher& watcher,
                                                    std::string_view role, const TopicInfo& request,
                                                    const TopicInfo& reply, const Types& types, Mailbox& mailbox,
                                                    const ClientSettings& settings);
  ~ClientCore();
  Result<std::string> submit(std::shared_ptr<void> request, Completion completion);
  void on_waiting(std::function<void(const std::string&)> callback);
  int pending() const;
  unsigned window() const;
  void cancel_all();
  ClientCounters counters() const;

  struct Impl;

 private:
  explicit ClientCore(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

template <class Request, class Reply>
class JobClient {
 public:
  using Completion = std::function<void(Result<Reply>)>;

  /// Completions run in mailbox.run(). The watcher and the mailbox must outlive the client.
  static Result<JobClient> create(const Participant& participant, StatusWatcher& watcher,
                                  const JobTopics<Request, Reply>& topics, Mailbox& mailbox,
                                  const ClientSettings& settings = {}) {
    const ClientCore::Types types{
        typeid(Request), typeid(Reply),
        [](void* request) -> primo_msgs::msg::JobHeader& { return static_cast<Request*>(request)->job(); },
        [](const void* reply) -> const primo_msgs::msg::ReplyHeader& {
          return static_cast<const Reply*>(reply)->reply();
        },
        [](void* reply) -> std::shared_ptr<void> {
          return std::make_shared<Reply>(std::move(*static_cast<Reply*>(reply)));
        }};
    PRIMO_ASSIGN(auto core, ClientCore::create(participant, watcher, topics.role, topic_info(topics.request.name),
                                               topic_info(topics.reply.name), types, mailbox, settings));
    return JobClient(std::move(core));
  }

  /// Takes the job and returns its id; its head is filled in but for `study`. `completion` gets the reply, or the
  /// worker's error, or what became of the attempts; exactly once. Error: unavailable when too many jobs are
  /// unanswered.
  Result<std::string> submit(Request request, Completion completion) {
    return core_->submit(std::make_shared<Request>(std::move(request)),
                         [completion = std::move(completion)](Result<std::shared_ptr<void>> reply) {
                           if (reply.ok()) {
                             completion(std::move(*static_cast<Reply*>(reply->get())));
                           } else {
                             completion(reply.error());
                           }
                         });
  }

  /// Called when jobs wait and no worker is there ("a planner; none is up"), and with "" when that is over; from a
  /// thread of the bus.
  void on_waiting(std::function<void(const std::string&)> callback) { core_->on_waiting(std::move(callback)); }
  int pending() const { return core_->pending(); }
  /// The sum of the live workers' credits: how many jobs are worth having under way.
  unsigned window() const { return core_->window(); }
  /// Forgets all jobs; their completions are not called.
  void cancel_all() { core_->cancel_all(); }
  ClientCounters counters() const { return core_->counters(); }

 private:
  explicit JobClient(std::unique_ptr<ClientCore> core) : core_(std::move(core)) {}
  std::unique_ptr<ClientCore> core_;
};

}  // namespace primo::bus
