// conductor: runs studies. With --study it runs that one and ends; without, it works on the study that the run-time
// folder assigns to it. Its state is the study's journal: started again it goes on where the journal ends.
#include <chrono>
#include <cstdlib>
#include <optional>

#include "common/assignment.h"
#include "common/dds_workers.h"
#include "common/progress.h"
#include "core/rate_limit.h"
#include "service/service.h"
#include "study/loop.h"

namespace primo {
namespace {

namespace fs = std::filesystem;

struct ConductorConfig {
  std::string study, directory, run;
  double deadline = 20;
  int attempts = 10;
  double map_rate = 1;
  template <class V>
  void visit(V&& v) {
    v("study", study, {.help = "study file to run; empty: what the run-time folder assigns"});
    v("directory", directory, {.help = "of the study's journal and result; with study"});
    v("run", run, {.help = "run-time folder; empty: PRIMO_RUN"});
    v("deadline", deadline,
      {.help = "of a plan or a verdict, before it is asked for elsewhere", .unit = "s", .min = 0.1, .max = 3600});
    v("attempts", attempts, {.help = "of a plan or a verdict, before the study fails", .min = 1, .max = 1000});
    v("map_rate", map_rate,
      {.help = "of the scenes observed, so many are published with their occupancy map",
       .unit = "Hz",
       .min = 0,
       .max = 1000});
  }
  Status validate() const {
    if (study.empty() != directory.empty()) {
      return Error{Code::config,
                   "'study' and 'directory' belong together: give both, or neither to work on assignments"};
    }
    return success();
  }
};

/// Whether something happened to the assignment in hand; looked at no more often than is noticed.
class AssignmentWatch {
 public:
  AssignmentWatch(fs::path run, std::string id) : run_(std::move(run)), id_(std::move(id)) {}
  bool replaced() {
    if (!looks_.due()) return replaced_;
    const auto written = graph::assignment_time(run_);
    if (written && written == written_) return replaced_;
    written_ = written;
    const auto assignment = graph::read_assignment(run_);
    replaced_ = !assignment.ok() || !*assignment || (*assignment)->id != id_;
    return replaced_;
  }

 private:
  fs::path run_;
  std::string id_;
  RateLimit looks_{5};
  std::optional<fs::file_time_type> written_;  // of the assignment that was read
  bool replaced_ = false;
};

class Conductor {
 public:
  Conductor(const ConductorConfig& config, service::Context& context, graph::ProgressPublisher progress)
      : context_(context), progress_(std::move(progress)), map_rate_(config.map_rate) {
    client_.deadline = std::chrono::milliseconds(static_cast<int>(config.deadline * 1000));
    client_.attempts = config.attempts;
  }

  /// Runs the study in its directory, until it ends or `stopping`.
  Status run_study(const study::Study& study, const fs::path& directory, const std::function<bool()>& stopping) {
    context_.log().info("study {} in {}", study.id(), directory.string());
    const graph::Waiting waiting{stopping, [this](const std::string& text) { context_.waiting_for(text); }};
    PRIMO_ASSIGN(const auto watcher, context_.make_watcher());
    PRIMO_ASSIGN(auto workers,
                 graph::DdsWorkers::create(context_.participant(), *watcher, waiting, client_, map_rate_));
    const auto on_progress = [this](const study::Progress& state) {
      if (const auto status = progress_.publish(state); !status.ok()) context_.log().warn("{}", status.error().message);
    };
    context_.status().job_started();
    const auto result = study::run_study(study, directory, *workers, on_progress);
    const bool interrupted = !result.ok() && stopping();
    context_.status().job_finished(result.ok() || interrupted, result.ok() ? "" : result.error().message);
    if (!result.ok()) return result.error();
    context_.log().info("study {} is complete", study.id());
    return success();
  }

  /// Works on assignments until told to end.
  Status serve(const fs::path& run) {
    context_.status().set_state(bus::State::idle);
    for (std::string ended; !context_.stopping(); context_.wait(std::chrono::milliseconds(200))) {
      const auto assignment = graph::read_assignment(run);
      if (!assignment.ok()) {
        context_.status().set_error(assignment.error().message);
        continue;
      }
      if (!*assignment || (*assignment)->id == ended) continue;
      const auto outcome = graph::read_outcome(run);
      if (outcome.ok() && *outcome && (*outcome)->id == (*assignment)->id) {
        ended = (*assignment)->id;
        continue;
      }
      PRIMO_TRY(work_on(run, **assignment));
    }
    return success();
  }

 private:
  Status work_on(const fs::path& run, const graph::Assignment& assignment) {
    AssignmentWatch watch(run, assignment.id);
    const auto stopping = [&] { return context_.stopping() || watch.replaced(); };
    const auto study = study::read_study(assignment.directory);
    const Status status = study.ok() ? run_study(*study, assignment.directory, stopping) : Status(study.error());
    if (!status.ok() && stopping()) return success();  // not an end: it is taken up again, or nobody wants it
    graph::Outcome outcome{assignment.id, 0, ""};
    if (!status.ok()) {
      context_.log().error("{}", status.error().message);
      outcome.exit = exit_code(status.error().code);
      outcome.message = status.error().message;
    }
    return graph::write_outcome(run, outcome);
  }

  service::Context& context_;
  graph::ProgressPublisher progress_;
  double map_rate_;
  bus::ClientSettings client_;
};

Status run(const ConductorConfig& config, service::Context& context) {
  PRIMO_ASSIGN(auto progress, graph::ProgressPublisher::create(context.participant(), "conductor"));
  Conductor conductor(config, context, std::move(progress));
  if (!config.study.empty()) {
    PRIMO_ASSIGN(const auto study, study::load_study(config.study));
    PRIMO_TRY(study::adopt_directory(study, config.directory));
    return conductor.run_study(study, fs::absolute(config.directory), [&] { return context.stopping(); });
  }
  const char* folder = std::getenv("PRIMO_RUN");
  const fs::path run = !config.run.empty() ? config.run : folder ? folder : "";
  if (run.empty()) {
    return Error{Code::config, "no study and no run-time folder: give --study and --directory, or set PRIMO_RUN"};
  }
  return conductor.serve(run);
}

}  // namespace
}  // namespace primo

int main(int argc, char** argv) {
  return primo::service::run<primo::ConductorConfig>(
      "conductor", argc, argv, primo::run,
      {{"--study", "FILE", "study", "the study to run"},
       {"--directory", "DIR", "directory", "of its journal and result"}});
}
