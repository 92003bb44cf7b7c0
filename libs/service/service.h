// A process of the graph: command line, configuration, logging, signals, status and exit codes, so that a service's
// main is its configuration and its handler.
//
//   int main(int argc, char** argv) {
//     return primo::service::run<JudgeConfig>("judge", argc, argv, [](const JudgeConfig& config, service::Context&
//     context) {
//       const physics::Judge judge(config.judge);
//       return context.serve(topics::kJudge, [&](const msg::JudgeJob& job) -> Result<msg::JudgeReply> { … });
//     });
//   }
//
// The YAML file holds the fields of the service's Config at its top level and those of Common under `service:`.
#pragma once

#include <spdlog/logger.h>

#include <functional>
#include <memory>
#include <stop_token>
#include <string>
#include <vector>

#include "bus/job_client.h"
#include "bus/job_server.h"
#include "bus/participant.h"
#include "bus/status.h"
#include "config/config.h"

namespace primo::service {

/// What every service can be told.
struct Common {
  std::string name;  ///< empty: the role
  bus::BusSettings bus;
  int credits = 2;
  int lease_ms = 500;
  double drain_seconds = 5;
  std::string log_level = "info";
  template <class V>
  void visit(V&& v) {
    v("name", name, {.help = "of this process, e.g. planner1; empty: the role"});
    v("bus", bus, {});
    v("credits", credits, {.help = "jobs one requester may have here at a time", .min = 1, .max = 64});
    v("lease_ms", lease_ms, {.help = "others notice a death within this", .unit = "ms", .min = 100, .max = 60000});
    v("drain_seconds", drain_seconds,
      {.help = "for the job in work, when told to stop", .unit = "s", .min = 0.1, .max = 600});
    v("log_level", log_level, {.choices = {"debug", "info", "warn", "error"}});
  }
};

/// A command line option that sets a key of the configuration: {"--study", "FILE", "study", "the study to run"}.
struct Option {
  std::string flag, value_name, key, help;
};

/// What a running service is given.
class Context {
 public:
  bus::Participant& participant();
  bus::StatusPublisher& status();
  /// Who is there. To be had no longer than needed: every watcher costs every process some messages a second.
  Result<std::unique_ptr<bus::StatusWatcher>> make_watcher();
  spdlog::logger& log();
  const std::string& name() const;
  const Common& common() const;

  /// Whether the process was told to end (SIGTERM, SIGINT), and a token of it.
  bool stopping() const;
  std::stop_token stop_token() const;
  /// Sleeps until told to end or the time has passed; returns stopping().
  bool wait(std::chrono::milliseconds timeout);
  void stop();
  /// Whether the process was stopped so long that it has to be started anew (exit code 69).
  bool forgotten() const;

  /// Says in status and log what the process waits for; "" when it no longer does.
  void waiting_for(const std::string& text);

  /// Serves jobs until told to end, then finishes the one in work.
  template <class Request, class Reply>
  Status serve(const bus::JobTopics<Request, Reply>& topics, typename bus::JobServer<Request, Reply>::Handler handler) {
    PRIMO_ASSIGN(auto server, (bus::JobServer<Request, Reply>::create(participant(), status(), topics,
                                                                      std::move(handler), server_settings())));
    started();
    while (!wait(std::chrono::hours(1))) {
    }
    if (!server.drain(drain_time())) give_up_draining();
    return success();
  }

  struct Impl;
  explicit Context(std::unique_ptr<Impl> impl);
  ~Context();

 private:
  bus::ServerSettings server_settings() const;
  std::chrono::milliseconds drain_time() const;
  void started();
  [[noreturn]] void give_up_draining();
  std::unique_ptr<Impl> impl_;
};

/// What the command line says; the rest of run() without its types.
struct Launch {
  std::string role;
  std::vector<Option> options;
  std::string description;                                                          ///< config::describe()
  std::function<Result<std::string>(const YAML::Node&, const std::string&)> check;  ///< reads; the effective dump
  std::function<const Common&()> common;                                            ///< after check()
  std::function<Status(Context&)> body;
};
int launch(const Launch& launch, int argc, char** argv);

namespace detail {
template <class Config>
struct Whole {
  Common service;
  Config config;
  template <class V>
  void visit(V&& v) {
    config.visit(v);
    v("service", service, {});
  }
  Status validate() const {
    if constexpr (requires {
                    { config.validate() } -> std::convertible_to<Status>;
                  })
      return config.validate();
    return success();
  }
};
}  // namespace detail

/// Runs `fn(const Config&, Context&)`, which returns Status (or void), as the process's work. Returns the exit code: 0;
/// 1 the work failed; 64 usage; 69 the bus cannot be had; 70 internal; 78 configuration.
template <class Config, class Function>
int run(const std::string& role, int argc, char** argv, Function fn, std::vector<Option> options = {}) {
  using Whole = detail::Whole<Config>;
  Whole whole;
  Launch launching;
  launching.role = role;
  launching.options = std::move(options);
  launching.description = config::describe<Whole>();
  launching.check = [&whole](const YAML::Node& node, const std::string& where) -> Result<std::string> {
    PRIMO_ASSIGN(whole, config::read_node<Whole>(node, where));
    return config::dump(whole);
  };
  launching.common = [&whole]() -> const Common& { return whole.service; };
  launching.body = [&whole, &fn](Context& context) -> Status {
    if constexpr (std::is_void_v<std::invoke_result_t<Function&, const Config&, Context&>>) {
      fn(std::as_const(whole.config), context);
      return success();
    } else {
      return fn(std::as_const(whole.config), context);
    }
  };
  return launch(launching, argc, argv);
}

}  // namespace primo::service
