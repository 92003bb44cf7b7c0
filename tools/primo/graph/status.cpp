// primo status: who is there and how they do.
#include "bus/status.h"

#include <spdlog/spdlog.h>

#include <chrono>
#include <cstdio>
#include <iostream>
#include <memory>
#include <nlohmann/json.hpp>
#include <thread>
#include <utility>

#include "primo/graph/supervisor.h"
#include "primo/verbs.h"

namespace primo::tool {
namespace {

struct Options {
  std::string run;
  int domain = -1;
  bool json = false;
};

/// Everyone's status. They come one by one after the first: waits until nobody new has come for a while.
std::vector<bus::WorkerInfo> gather(const bus::StatusWatcher& watcher) {
  using Clock = std::chrono::steady_clock;
  std::size_t expected = 0;
  for (const auto& [role, count] : expected_workers()) expected += static_cast<std::size_t>(count);
  const auto begin = Clock::now();
  auto changed = begin;
  for (std::size_t seen = 0;;) {
    auto workers = watcher.workers();
    const auto now = Clock::now();
    if (workers.size() != std::exchange(seen, workers.size())) changed = now;
    const bool settled = seen > 0 && now - changed > std::chrono::seconds(1);
    if (seen >= expected || settled || now - begin > std::chrono::seconds(3)) return workers;
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
  }
}

void print_table(const std::vector<bus::WorkerInfo>& workers) {
  std::vector<std::vector<std::string>> rows = {{"role", "id", "pid", "host", "state", "done", "per s", "last error"}};
  for (const auto& worker : workers) {
    std::string state = config::enum_name(worker.state);
    if (!worker.waiting_for.empty()) state += " for " + worker.waiting_for;
    char rate[32];
    std::snprintf(rate, sizeof rate, "%.1f", worker.jobs_per_second);
    rows.push_back({worker.role, worker.worker, std::to_string(worker.pid), worker.host, state,
                    std::to_string(worker.jobs_done), rate, worker.last_error});
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

void print_json(const std::vector<bus::WorkerInfo>& workers) {
  auto array = nlohmann::ordered_json::array();
  for (const auto& worker : workers) {
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
  std::cout << array.dump(2) << "\n";
}

Status show(const Options& options) {
  PRIMO_ASSIGN(const Layout layout, find_layout(options.run, options.domain));
  bus::BusSettings bus;
  bus.domain_override = layout.domain;
  PRIMO_ASSIGN(const auto participant, bus::Participant::create(bus, "primo_status"));
  PRIMO_ASSIGN(const auto watcher, bus::StatusWatcher::create(participant));
  const auto workers = gather(*watcher);
  if (options.json) {
    print_json(workers);
  } else if (!workers.empty()) {
    print_table(workers);
  }
  if (workers.empty()) {
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
