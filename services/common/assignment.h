// How a study is given to the conductor of a graph: a file in the run-time folder, and one with what became of it.
// Files, and not a topic, because an assignment must outlive whoever gave it and every process of the graph.
#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "config/config.h"
#include "core/result.h"

namespace primo::graph {

/// run/assignment.yaml: the study in hand.
struct Assignment {
  std::string id;         ///< unique for each giving
  std::string directory;  ///< of the study; holds study.yaml
  template <class V>
  void visit(V&& v) {
    v("id", id, {.help = "unique for each giving", .required = true});
    v("directory", directory, {.help = "the study's, with its study.yaml", .required = true});
  }
};

/// run/outcome.yaml: how the assignment of this id ended.
struct Outcome {
  std::string id;
  int exit = 0;         ///< the exit code that says it: 0 done, 1 failed, 69, 70, 78
  std::string message;  ///< empty when done
  template <class V>
  void visit(V&& v) {
    v("id", id, {.required = true});
    v("exit", exit, {.min = 0, .max = 255, .required = true});
    v("message", message, {});
  }
};

/// Empty where there is none.
Result<std::optional<Assignment>> read_assignment(const std::filesystem::path& run);
/// When it was written; empty where there is none.
std::optional<std::filesystem::file_time_type> assignment_time(const std::filesystem::path& run);
Result<std::optional<Outcome>> read_outcome(const std::filesystem::path& run);
Status write_assignment(const std::filesystem::path& run, const Assignment& assignment);
Status write_outcome(const std::filesystem::path& run, const Outcome& outcome);
/// Takes the assignment back: the conductor stops working on it.
Status withdraw_assignment(const std::filesystem::path& run);

}  // namespace primo::graph
