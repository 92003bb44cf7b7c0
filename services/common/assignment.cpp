#include "common/assignment.h"

#include "core/files.h"

namespace primo::graph {
namespace fs = std::filesystem;
namespace {

template <class T>
Result<std::optional<T>> read_if_there(const fs::path& path) {
  std::error_code ec;
  if (!fs::exists(path, ec)) return std::optional<T>();
  PRIMO_ASSIGN(auto value, config::read<T>(path));
  return std::optional<T>(std::move(value));
}

fs::path assignment_file(const fs::path& run) { return run / "assignment.yaml"; }
fs::path outcome_file(const fs::path& run) { return run / "outcome.yaml"; }

}  // namespace

Result<std::optional<Assignment>> read_assignment(const fs::path& run) {
  return read_if_there<Assignment>(assignment_file(run));
}
std::optional<fs::file_time_type> assignment_time(const fs::path& run) {
  std::error_code ec;
  const auto time = fs::last_write_time(assignment_file(run), ec);
  return ec ? std::nullopt : std::optional(time);
}
Result<std::optional<Outcome>> read_outcome(const fs::path& run) { return read_if_there<Outcome>(outcome_file(run)); }

Status write_assignment(const fs::path& run, const Assignment& assignment) {
  return write_file(assignment_file(run), config::dump(assignment));
}
Status write_outcome(const fs::path& run, const Outcome& outcome) {
  return write_file(outcome_file(run), config::dump(outcome));
}

Status withdraw_assignment(const fs::path& run) {
  std::error_code ec;
  fs::remove(assignment_file(run), ec);
  if (ec) return Error{Code::failed, assignment_file(run).string() + ": cannot be removed: " + ec.message()};
  return success();
}

}  // namespace primo::graph
