// The study's report: one HTML file with everything in it.
#pragma once

#include <filesystem>

#include "core/result.h"

namespace primo::study {

/// Writes report/index.html in a study's directory from its study.yaml, journal.db and result.json, and returns its
/// path. Pictures are rendered from plans that are made again from the recorded requests.
Result<std::filesystem::path> write_report(const std::filesystem::path& study_directory);

}  // namespace primo::study
