// Files that are never half-written.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>

#include "core/result.h"

namespace primo {

/// The whole file; Code::config when it cannot be read.
Result<std::string> read_file(const std::filesystem::path& path);

/// Writes `content` to a neighbour, syncs it and renames it over `path`: readers see the old file or the new one.
Status write_file(const std::filesystem::path& path, std::string_view content);

}  // namespace primo
