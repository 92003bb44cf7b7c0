// Files of experiences: one JSON object a line, read one after the other so that a file may be larger than memory.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <istream>

#include "symbols/literal.h"

namespace primo::symbols {

struct ExperienceFileOptions {
  bool skip_bad = false;  ///< lines that cannot be used are counted instead of ending the reading
};

struct ExperienceFileSummary {
  std::int64_t experiences = 0;
  std::int64_t skipped = 0;
  std::string first_skipped;  ///< "file:line: reason" of the first bad line
};

/// Gives every experience to `use` with "name:line". Empty lines are passed over. Error (data), with file, line and
/// reason: a line that is no experience, is longer than 64 MiB, uses a predicate with another number of arguments than
/// a line before, or that `use` refuses.
Result<ExperienceFileSummary> read_experiences(
    std::istream& lines, const std::string& name, const ExperienceFileOptions& options,
    const std::function<Status(Experience&&, const std::string& where)>& use);

/// The same of a file. Error (config): it cannot be read.
Result<ExperienceFileSummary> read_experience_file(
    const std::filesystem::path& path, const ExperienceFileOptions& options,
    const std::function<Status(Experience&&, const std::string& where)>& use);

}  // namespace primo::symbols
