// A worker's side of jobs: requests in its partition, one handler thread, replies to each requester's partition.
#pragma once

#include <primo_common.h>

#include <chrono>
#include <functional>
#include <memory>
#include <string>
#include <typeindex>
#include <typeinfo>

#include "bus/participant.h"
#include "bus/status.h"
#include "bus/topics.h"

namespace primo::bus {

struct ServerSettings {
  unsigned credits = 2;  ///< jobs one requester may have here at a time: one in work, one waiting
  int queue =
      64;  ///< jobs waiting at most; further ones are answered "unavailable", and their requester sends them elsewhere
};

/// The untyped server. See JobServer.
class ServerCore {
 public:
  struct Types {
    std::type_index request, reply;
    const primo_msgs::msg::JobHeader& (*request_head)(const void*);
    primo_msgs::msg::ReplyHeader& (*reply_head)(void*);
    std::shared_ptr<void> (*steal_request)(void*);
    std::shared_ptr<void> (*new_reply)();
  };
  /// Fills the reply's body.
  using Handler = std::function<Status(const void* request, void* reply)>;

  static Result<std::unique_ptr<ServerCore>> create(const Participant& participant, StatusPublisher& status,
                                                    const TopicInfo& request, const TopicInfo& reply,
                                                    const Types& types, Handler handler,
                                                    const ServerSettings& settings);
  ~ServerCore();
  bool drain(std::chrono::milliseconds timeout);

  struct Impl;

 private:
  explicit ServerCore(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

template <class Request, class Reply>
class JobServer {
 public:
  /// A pure function of the request without its head. Its errors reach the requester as they are; exceptions as
  /// Code::internal.
  using Handler = std::function<Result<Reply>(const Request&)>;

  /// Takes jobs from now on: sets the status's credits and state. The status must outlive the server.
  static Result<JobServer> create(const Participant& participant, StatusPublisher& status,
                                  const JobTopics<Request, Reply>& topics, Handler handler,
                                  const ServerSettings& settings = {}) {
    const ServerCore::Types types{
        typeid(Request),
        typeid(Reply),
        [](const void* request) -> const primo_msgs::msg::JobHeader& {
          return static_cast<const Request*>(request)->job();
        },
        [](void* reply) -> primo_msgs::msg::ReplyHeader& { return static_cast<Reply*>(reply)->reply(); },
        [](void* request) -> std::shared_ptr<void> {
          return std::make_shared<Request>(std::move(*static_cast<Request*>(request)));
        },
        []() -> std::shared_ptr<void> { return std::make_shared<Reply>(); }};
    auto untyped = [handler = std::move(handler)](const void* request, void* reply) -> Status {
      PRIMO_ASSIGN(*static_cast<Reply*>(reply), handler(*static_cast<const Request*>(request)));
      return success();
    };
    PRIMO_ASSIGN(auto core, ServerCore::create(participant, status, topic_info(topics.request.name),
                                               topic_info(topics.reply.name), types, std::move(untyped), settings));
    return JobServer(std::move(core));
  }

  /// Finishes the job in work, hands the waiting ones back and takes no more. False when the handler is still at it
  /// after the time.
  bool drain(std::chrono::milliseconds timeout) { return core_->drain(timeout); }

 private:
  explicit JobServer(std::unique_ptr<ServerCore> core) : core_(std::move(core)) {}
  std::unique_ptr<ServerCore> core_;
};

}  // namespace primo::bus
