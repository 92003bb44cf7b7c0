// The verbs of the command line: one file each, and their table.
#pragma once

#include <CLI/CLI.hpp>
#include <cstdio>
#include <string>
#include <vector>

#include "core/result.h"

namespace primo::tool {

/// Adds a verb's sub-command to the application; its callback leaves the process's exit code in `exit`.
using AddVerb = void (*)(CLI::App& app, int& exit);

void add_config(CLI::App& app, int& exit);
void add_judge(CLI::App& app, int& exit);
void add_optimize(CLI::App& app, int& exit);
void add_plan(CLI::App& app, int& exit);
void add_rollout(CLI::App& app, int& exit);
void add_rules(CLI::App& app, int& exit);
void add_scenario(CLI::App& app, int& exit);
void add_study(CLI::App& app, int& exit);
/// `primo scenario select`, under the verb `scenario`.
void add_scenario_select(CLI::App& scenario, int& exit);
#ifdef PRIMO_WITH_DDS
void add_down(CLI::App& app, int& exit);
void add_status(CLI::App& app, int& exit);
void add_up(CLI::App& app, int& exit);
#endif

/// The table of verbs, in the order of --help.
std::vector<AddVerb> verbs();

/// Prints the error as one line and gives its exit code; 0 on success.
inline int report(const Status& status) {
  if (status.ok()) return 0;
  std::fprintf(stderr, "primo: %s\n", status.error().message.c_str());
  return exit_code(status.error().code);
}

}  // namespace primo::tool
