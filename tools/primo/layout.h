// Where things are: the checkout, the executables, the run-time folder of a graph.
#pragma once

#include <filesystem>
#include <string>

#include "core/result.h"

namespace primo::tool {

struct Layout {
  std::filesystem::path
      root;  ///< holds compose/, services/, configs/: PRIMO_ROOT, or the first such folder above the executable
  std::filesystem::path bin;       ///< folder of this executable
  std::filesystem::path services;  ///< configurations of the services: PRIMO_SERVICES, or services/ of the root
  std::filesystem::path run;       ///< sockets, logs, the study in hand
  std::filesystem::path robot;     ///< robot file of the graph that is up, else the default one
  int domain = 0;                  ///< DDS domain
};

/// `run`: the --run option; empty: PRIMO_RUN, or .primo in the root. `domain`: the --domain option; −1: that of the
/// graph which is up in `run`, else PRIMO_DOMAIN, else 0.
Result<Layout> find_layout(const std::string& run = "", int domain = -1);

/// Remembers domain and robot of the graph in the run-time folder, for find_layout; forget_graph undoes it.
Status remember_graph(const Layout& layout);
void forget_graph(const Layout& layout);

/// A free folder name for what stood at `path`: path.1, path.2, …; moves it there. Nothing is done where nothing
/// stands.
Result<std::filesystem::path> move_aside(const std::filesystem::path& path);

}  // namespace primo::tool
