// Other programs of the system, run as children.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "core/result.h"

namespace primo {

struct Finished {
  int exit = 0;        ///< its exit code; 128 where a signal ended it
  std::string output;  ///< what it wrote, standard error included; at most kMostOutput bytes, the rest is dropped
  static constexpr std::size_t kMostOutput = 1 << 20;
};

/// Runs words[0] with the others as its arguments in `directory` (empty: the present one), without a shell and without
/// input, and waits for its end. Error (unavailable): there is no such program.
Result<Finished> run_program(const std::vector<std::string>& words, const std::filesystem::path& directory = {});

}  // namespace primo
