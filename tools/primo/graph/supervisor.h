// Starting and stopping the processes of the graph through supervisord.
#pragma once

#include <sys/types.h>

#include <optional>
#include <string>
#include <vector>

#include "primo/layout.h"

namespace primo::tool {

/// What compose/supervisord.conf starts: a role and how many of it.
struct Expected {
  std::string role;
  int count = 1;
};
constexpr int kWorkers = 2;  ///< planners, and judges, of the file as it is
std::vector<Expected> expected_workers(int workers = kWorkers);

/// The supervisord of this run-time folder, when it lives.
std::optional<pid_t> supervisor_pid(const Layout& layout);

/// Processes that belong to this run-time folder, supervisord aside.
std::vector<pid_t> graph_processes(const Layout& layout);

/// The role that a process of the graph has, by its executable; empty when it is gone.
std::string process_role(pid_t pid);

/// Asks every service to check its configuration. The first that refuses: its own line, Code::config.
Status check_services(const Layout& layout);

/// Starts supervisord with so many planners and judges, as a daemon or in the place of this process (then it returns
/// only on failure).
Status start_supervisor(const Layout& layout, int workers, bool foreground);

/// Stops supervisord and every process of the run-time folder, and removes what they left there and in shared memory.
Status stop_graph(const Layout& layout);

}  // namespace primo::tool
