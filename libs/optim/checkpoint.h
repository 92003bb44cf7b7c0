// An optimizer on disk: a small readable file (JSON, a line a quantity) from which it goes on bit for bit. It names the
// problem and the settings it belongs to and carries a digest of itself; it is replaced as a whole or not at all.
#pragma once

#include <filesystem>
#include <memory>
#include <string>

#include "optim/optimizer.h"

namespace primo::optim {

/// `problem`: what is optimized, in words that differ where the function differs, e.g. "sphere".
std::string checkpoint_text(const Optimizer& optimizer, const std::string& problem);

/// The optimizer of this text. Errors (data): not a checkpoint, damaged, of another version. Error (config): of another
/// problem, other settings or bounds; the first that differs is named with both values. The budget alone may differ.
Result<std::unique_ptr<Optimizer>> optimizer_from_text(const std::string& text, const OptimizerSettings& settings,
                                                       const Bounds& bounds, const std::string& problem);

/// Writes the file anew, in one step. Error (config or data): what is there already cannot be replaced: it is no
/// checkpoint of this search, is damaged, or is further ahead. It is left as it is.
Status save_checkpoint(const std::filesystem::path& file, const Optimizer& optimizer, const std::string& problem);

/// The optimizer of this file, or a new one where there is no file.
Result<std::unique_ptr<Optimizer>> load_checkpoint(const std::filesystem::path& file, const OptimizerSettings& settings,
                                                   const Bounds& bounds, const std::string& problem);

}  // namespace primo::optim
