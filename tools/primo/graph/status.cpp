// primo status: who is there and how they do.
#include "bus/status.h"

#include <spdlog/spdlog.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <iostream>
#include <memory>
#include <nlohmann/json.hpp>
#include <thread>
#include <utility>
#include <vector>

#include "primo/graph/supervisor.h"
#include "primo/verbs.h"

namespace primo::tool {
namespace {

struct Options {
  std::string run;
  int domain = -1;
  bool json = false;
};

struct Gathered {
  std::vector<bus::WorkerInfo> workers;
  std::vector<std::pair<std::string, pid_t>> silent;  ///< role and number of this machine's processes that say nothing
};

/// Everyone's status. Where the graph runs on this machine, waits at most 5 s for each of its processes; elsewhere
/// until nobody new has come for a second.
Gathered gather(const bus::StatusWatcher& watcher, const Layout& layout) {
  using Clock = std::chrono::steady_clock;
  const auto begin = Clock::now();
  auto changed = begin;
  for (std::size_t seen = 0;;) {
    Gathered found{watcher.workers(), {}};
    const auto now = Clock::now();
    const auto local = graph_processes(layout);
    for (const pid_t pid : local) {
      const auto its = [pid](const bus::WorkerInfo& worker) { return worker.pid == pid; };
      if (std::none_of(found.workers.begin(), found.workers.end(), its))
        found.silent.emplace_back(process_role(pid), pid);
    }
    if (found.workers.size() != std::exchange(seen, found.workers.size())) changed = now;
    if (!local.empty() && found.silent.empty()) return found;
    const bool settled = local.empty() && seen > 0 && now - changed > std::chrono::seconds(1);
    if (settled || now - begin > std::chrono::seconds(local.empty() ? 3 : 5)) return found;
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
  }
}

void print_table(const Gathered& found) {
  std::vector<std::vector<std::string>> rows = {{"role", "id", "pid", "host", "state", "done", "per s", "last error"}};
  for (const auto& worker : found.workers) {
    std::string state = config::enum_name(worker.state);
    if (!worker.waiting_for.empty()) state += " for " + worker.waiting_for;
    char rate[32];
    std::snprintf(rate, sizeof rate, "%.1f", worker.jobs_per_second);
    rows.push_back({worker.role, worker.worker, std::to_string(worker.pid), worker.host, state,
                    std::to_string(worker.jobs_done), rate, worker.last_error});
  }
  for (const auto& [role, pid] : found.silent) {
    rows.push_back(
        {role, "-", std::to_string(pid), "this one", "silent", "-", "-", "runs, but does not tell its status"});
  }
  std::vector<std::size_t> widths(rows.front().size(), 0);
  for (const auto& row : rows) {
    for (std::size_t i = 0; i + 1 < row.size(); ++i) widths[i] = std::max(widths[i], row[i].size());
  }
  for (const auto& row : rows) {
    std::string line;
    for (std::size_t i = 0; i < row.size(); ++i) {
      line += row[i];
      if (i + 1 < row.size()) line.append(widths[i] - row[i].size() + 2, ' ');
    }
    line.erase(line.find_last_not_of(' ') + 1);
    std::cout << line << "\n";
  }
}

void print_json(const Gathered& found) {
  auto array = nlohmann::ordered_json::array();
  for (const auto& worker : found.workers) {
    array.push_back({{"role", worker.role},
                     {"name", worker.name},
                     {"id", worker.worker},
                     {"pid", worker.pid},
                     {"host", worker.host},
                     {"state", config::enum_name(worker.state)},
                     {"waiting_for", worker.waiting_for},
                     {"jobs_done", worker.jobs_done},
                     {"jobs_failed", worker.jobs_failed},
                     {"jobs_per_second", worker.jobs_per_second},
                     {"last_error", worker.last_error},
                     {"config_hash", worker.config_hash},
                     {"version", worker.version}});
  }
  for (const auto& [role, pid] : found.silent) array.push_back({{"role", role}, {"pid", pid}, {"state", "silent"}});
  std::cout << array.dump(2) << "\n";
}

Status show(const Options& options) {
  PRIMO_ASSIGN(const Layout layout, find_layout(options.run, options.domain));
  bus::BusSettings bus;
  bus.domain_override = layout.domain;
  PRIMO_ASSIGN(const auto participant, bus::Participant::create(bus, "primo_status"));
  PRIMO_ASSIGN(const auto watcher, bus::StatusWatcher::create(participant));
  const Gathered found = gather(*watcher, layout);
  const bool nobody = found.workers.empty() && found.silent.empty();
  if (options.json) {
    print_json(found);
  } else if (!nobody) {
    print_table(found);
  }
  if (nobody) {
    return Error{Code::unavailable,
                 "nobody is in DDS domain " + std::to_string(layout.domain) + "; primo up starts the graph"};
  }
  return success();
}

}  // namespace

void add_status(CLI::App& app, int& exit) {
  const auto options = std::make_shared<Options>();
  auto* verb = app.add_subcommand("status", "shows every process of the graph");
  verb->add_option("--run", options->run, "run-time folder of the graph");
  verb->add_option("--domain", options->domain, "DDS domain (default: that of the graph, PRIMO_DOMAIN, or 0)")
      ->check(CLI::Range(0, 232));
  verb->add_flag("--json", options->json, "print JSON");
  verb->callback([options, &exit] {
    spdlog::set_level(spdlog::level::err);
    exit = report(show(*options));
  });
}

}  // namespace primo::tool
