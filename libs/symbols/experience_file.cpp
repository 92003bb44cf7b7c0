#include "symbols/experience_file.h"

#include <cerrno>
#include <cstring>
#include <fstream>

#include "symbols/literal_json.h"
#include "symbols/signatures.h"

namespace primo::symbols {
namespace {

enum class Line { whole, too_long, none };

/// getline() that stops keeping characters at the limit, so that a file without line ends is no danger.
Line next_line(std::istream& from, std::string& line) {
  line.clear();
  bool any = false, too_long = false;
  for (int c = from.get(); c != std::istream::traits_type::eof(); c = from.get()) {
    any = true;
    if (c == '\n') break;
    if (line.size() < kMaxJsonBytes) {
      line.push_back(static_cast<char>(c));
    } else {
      too_long = true;
    }
  }
  if (!any) return Line::none;
  return too_long ? Line::too_long : Line::whole;
}

}  // namespace

Result<ExperienceFileSummary> read_experiences(
    std::istream& lines, const std::string& name, const ExperienceFileOptions& options,
    const std::function<Status(Experience&&, const std::string& where)>& use) {
  ExperienceFileSummary summary;
  Signatures signatures;
  std::string line;
  for (std::int64_t number = 1;; ++number) {
    const Line kind = next_line(lines, line);
    if (kind == Line::none) break;
    if (line.find_first_not_of(" \t\r") == std::string::npos) continue;
    const std::string where = name + ":" + std::to_string(number);
    const auto take = [&]() -> Status {
      if (kind == Line::too_long) return Error{Code::data, where + ": the line is longer than 64 MiB"};
      auto experience = experience_from_json(line);
      if (!experience.ok()) return experience.error().at(where);
      PRIMO_TRY(signatures.add(*experience, where));
      return use(std::move(experience).value(), where);
    };
    const auto status = take();
    if (status.ok()) {
      ++summary.experiences;
    } else if (!options.skip_bad) {
      return status.error();
    } else if (++summary.skipped == 1) {
      summary.first_skipped = status.error().message;
    }
  }
  return summary;
}

Result<ExperienceFileSummary> read_experience_file(
    const std::filesystem::path& path, const ExperienceFileOptions& options,
    const std::function<Status(Experience&&, const std::string& where)>& use) {
  std::ifstream file(path, std::ios::binary);
  if (!file || std::filesystem::is_directory(path)) {
    return Error{Code::config,
                 "cannot read " + path.string() + ": " + (file ? "it is a directory" : std::strerror(errno))};
  }
  return read_experiences(file, path.string(), options, use);
}

}  // namespace primo::symbols
