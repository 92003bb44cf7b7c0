// primo up, primo down: the graph of services on this machine.
#include <spdlog/spdlog.h>

#include <chrono>
#include <iostream>
#include <memory>
#include <thread>

#include "bus/status.h"
#include "common/assignment.h"
#include "primo/graph/supervisor.h"
#include "primo/verbs.h"
#include "robot/robot.h"

namespace primo::tool {
namespace {

using Clock = std::chrono::steady_clock;

struct Options {
  std::string run, robot;
  int domain = -1, workers = kWorkers;
  double timeout = 30;
  bool foreground = false;
};

/// "a planner (1 of 2)", … of what is not there yet; empty when all are.
std::string missing(const bus::StatusWatcher& watcher, int workers) {
  std::string text;
  for (const auto& [role, count] : expected_workers(workers)) {
    int there = 0;
    for (const auto& worker : watcher.workers(role)) there += worker.state != bus::State::starting;
    if (there >= count) continue;
    text += (text.empty() ? "" : ", ") + role;
    if (count > 1) text += " (" + std::to_string(there) + " of " + std::to_string(count) + ")";
  }
  return text;
}

Status wait_for_all(const Layout& layout, const bus::StatusWatcher& watcher, const Options& options) {
  const auto end = Clock::now() + std::chrono::duration<double>(options.timeout);
  auto said_at = Clock::now();
  std::string said;
  for (;;) {
    const std::string text = missing(watcher, options.workers);
    if (text.empty()) return success();
    if (Clock::now() > end) {
      return Error{Code::unavailable, "not up after " + std::to_string(static_cast<int>(options.timeout)) +
                                          " s: " + text + ". Their logs are in " + layout.run.string()};
    }
    if (text != said && Clock::now() - said_at > std::chrono::seconds(1)) {
      std::cout << "primo: waiting for " << text << std::endl;
      said = text;
      said_at = Clock::now();
    }
    if (!supervisor_pid(layout)) {
      return Error{Code::unavailable, "supervisord ended; " + (layout.run / "supervisord.log").string() + " says why"};
    }
    std::this_thread::sleep_for(std::chrono::milliseconds(50));
  }
}

Status up(const Options& options) {
  PRIMO_ASSIGN(Layout layout, find_layout(options.run, options.domain));
  if (supervisor_pid(layout)) {
    std::cout << "primo: the graph is up already in " << layout.run.string() << "; primo status shows it\n";
    return success();
  }
  if (!graph_processes(layout).empty()) {
    std::cout << "primo: stopping what an earlier graph left running\n";
    PRIMO_TRY(stop_graph(layout));
  }
  if (!options.robot.empty()) layout.robot = std::filesystem::absolute(options.robot);
  if (const auto robot = robot::Robot::load(layout.robot); !robot.ok()) return robot.error();
  PRIMO_TRY(check_services(layout));
  if (options.foreground) return start_supervisor(layout, options.workers, true);

  const auto begin = Clock::now();
  bus::BusSettings bus;
  bus.domain_override = layout.domain;
  PRIMO_ASSIGN(const auto participant, bus::Participant::create(bus, "primo_up"));
  PRIMO_ASSIGN(const auto watcher, bus::StatusWatcher::create(participant));
  PRIMO_TRY(start_supervisor(layout, options.workers, false));
  if (const auto status = wait_for_all(layout, *watcher, options); !status.ok()) {
    if (const auto stopped = stop_graph(layout); !stopped.ok()) return stopped.error();
    return status.error();
  }
  std::cout << "primo: " << watcher->workers().size() << " processes up in "
            << std::chrono::duration_cast<std::chrono::milliseconds>(Clock::now() - begin).count() << " ms, domain "
            << layout.domain << "\n";
  return success();
}

Status down(const Options& options) {
  PRIMO_ASSIGN(const Layout layout, find_layout(options.run, options.domain));
  const bool was_up = supervisor_pid(layout) || !graph_processes(layout).empty();
  PRIMO_TRY(graph::withdraw_assignment(layout.run));
  PRIMO_TRY(stop_graph(layout));
  std::cout << (was_up ? "primo: the graph is stopped\n" : "primo: no graph was up\n");
  return success();
}

void add_common(CLI::App& verb, Options& options) {
  verb.add_option("--run", options.run,
                  "run-time folder: sockets, logs (default: PRIMO_RUN, or .primo in the checkout)");
  verb.add_option("--domain", options.domain, "DDS domain (default: that of the graph, PRIMO_DOMAIN, or 0)")
      ->check(CLI::Range(0, 232));
}

}  // namespace

void add_up(CLI::App& app, int& exit) {
  const auto options = std::make_shared<Options>();
  auto* verb = app.add_subcommand("up", "starts the graph of services and waits until all of it is there");
  add_common(*verb, *options);
  verb->add_option("--robot", options->robot, "robot file of planners and judges (default: the Schunk arm)");
  verb->add_option("--workers", options->workers,
                   "planners, and as many judges; a study's result does not depend on it")
      ->check(CLI::Range(1, 64))
      ->capture_default_str();
  verb->add_option("--timeout", options->timeout, "seconds to wait")
      ->check(CLI::Range(1.0, 3600.0))
      ->capture_default_str();
  verb->add_flag("--foreground", options->foreground, "stay in the foreground, until Ctrl-C");
  verb->callback([options, &exit] {
    spdlog::set_level(spdlog::level::err);
    exit = report(up(*options));
  });
}

void add_down(CLI::App& app, int& exit) {
  const auto options = std::make_shared<Options>();
  auto* verb = app.add_subcommand("down", "stops the graph; leaves no process and nothing in shared memory");
  add_common(*verb, *options);
  verb->callback([options, &exit] { exit = report(down(*options)); });
}

}  // namespace primo::tool
