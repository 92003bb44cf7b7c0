// A study run by the graph of services.
#pragma once

#include <filesystem>
#include <string>

#include "core/result.h"
#include "study/study.h"

namespace primo::tool {

/// Whether the graph of this run-time folder is up and was started for the study's robot. Errors: unavailable, config.
Status check_graph(const std::string& run, const study::Study& study);

/// Gives the study to the conductor, shows its progress, and returns when it has ended. An interrupt takes it back.
Status run_on_graph(const std::string& run, const study::Study& study, const std::filesystem::path& directory);

}  // namespace primo::tool
