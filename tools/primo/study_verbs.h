// What the verbs of primo study do beside running one.
#pragma once

#include <string>

#include "core/result.h"

namespace primo::tool {

/// Prints every key in which two studies (directories or study files) differ, "KEY: FIRST | SECOND", and where both
/// have results, the rates of P* side by side.
Status diff_studies(const std::string& first, const std::string& second);

/// The experiences of a study as JSON lines (what `primo rules learn` reads) or as CSV, into the file or, without one,
/// to standard output. @param format jsonl or csv
Status export_experience(const std::string& directory, const std::string& format, const std::string& file);

}  // namespace primo::tool
