// Experiences from anywhere: a file's lines are read or refused with file, line and reason; what was read is written
// and read the same, and can be learned from.
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <sstream>
#include <string>
#include <vector>

#include "rules/learner.h"
#include "symbols/experience_file.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  std::istringstream lines(std::string(data, data + size));
  std::vector<primo::symbols::Experience> read;
  const auto summary = primo::symbols::read_experiences(
      lines, "fuzz", {.skip_bad = true}, [&](primo::symbols::Experience&& experience, const std::string&) {
        const std::string line = to_json_line(experience);
        const auto again = primo::symbols::experience_from_json(line);
        if (!again.ok() || to_json_line(*again) != line) std::abort();
        read.push_back(std::move(experience));
        return primo::success();
      });
  if (!summary.ok() || (summary->skipped > 0 && summary->first_skipped.empty())) std::abort();
  if (read.size() <= 20) {
    const auto rules = primo::rules::learn(read, {.max_candidates = 200, .look_ahead = 0});
    if (!rules.ok() && rules.error().message.empty()) std::abort();
  }
  return 0;
}
