// primo study: run a study, by the graph or in this process; show its result; write its report.
#include "study/study.h"

#include <filesystem>
#include <iostream>
#include <memory>

#include "primo/interrupt.h"
#include "primo/layout.h"
#include "primo/progress_lines.h"
#include "primo/study_graph.h"
#include "primo/study_verbs.h"
#include "primo/verbs.h"
#include "study/local_workers.h"
#include "study/loop.h"
#include "study/report.h"
#include "study/result.h"

namespace primo::tool {
namespace {

namespace fs = std::filesystem;
using Clock = std::chrono::steady_clock;

struct Options {
  std::string file, directory, run, other, format = "jsonl";
  std::vector<std::string> set;
  bool local = false, anew = false, no_report = false;
  int threads = 0;
};

/// Progress of a study in this process, with the rate that the services' publisher adds otherwise.
class LocalProgress {
 public:
  void operator()(const study::Progress& progress) {
    const std::string stage = progress.part + progress.stage + progress.algorithm + progress.text;
    if (stage != stage_ || progress.done < last_) {
      stage_ = stage;
      begin_ = Clock::now();
      first_ = progress.done;
    }
    last_ = progress.done;
    const double seconds = std::chrono::duration<double>(Clock::now() - begin_).count();
    StageState state;
    state.part = progress.part;
    state.round = progress.round;
    state.stage = progress.stage;
    state.subject = progress.algorithm;
    state.done = progress.done;
    state.total = progress.total;
    if (state.subject.empty()) state.subject = progress.text;
    state.rate = seconds > 0.05 ? (progress.done - first_) / seconds : 0;
    state.seconds_left = state.rate > 0 ? (progress.total - progress.done) / state.rate : 0;
    state.searching = progress.stage == "optimize";
    state.best_gamma = progress.best_gamma;
    state.mean_gamma = progress.mean_gamma;
    state.sigma = progress.sigma;
    state.condition = progress.condition;
    state.success = progress.success;
    state.finished = progress.finished;
    if (progress.stage != "done") lines_.show(state);
  }
  ProgressLines& lines() { return lines_; }

 private:
  ProgressLines lines_;
  std::string stage_;
  Clock::time_point begin_{};
  int first_ = 0, last_ = 0;
};

Status run_locally(const study::Study& study, const fs::path& directory, int threads) {
  LocalProgress progress;
  const study::OnProgress on_progress = [&](const study::Progress& state) { progress(state); };
  study::LocalOptions local;
  local.threads = threads;
  local.stopping = interrupted;
  local.on_progress = on_progress;
  PRIMO_ASSIGN(auto workers, study::LocalWorkers::create(study.robot, std::move(local)));
  const auto result = study::run_study(study, directory, *workers, on_progress);
  progress.lines().close();
  if (!result.ok()) return result.error();
  return success();
}

/// The study's directory: given, or studies/NAME in the checkout.
Result<fs::path> directory_of(const Options& options, const study::Study& study) {
  if (!options.directory.empty()) return fs::absolute(options.directory).lexically_normal();
  PRIMO_ASSIGN(const Layout layout, find_layout(options.run));
  return layout.root / "studies" / study.name;
}

/// Makes the directory the study's; says whether its result stands there already.
Result<bool> prepare(const Options& options, const study::Study& study, const fs::path& directory) {
  if (options.anew) {
    PRIMO_ASSIGN(const fs::path aside, move_aside(directory));
    if (aside != directory)
      std::cout << "primo: starting anew; what stood in " << directory.string() << " is in " << aside.string() << "\n";
  }
  const auto adopted = study::adopt_directory(study, directory);
  if (!adopted.ok())
    return Error{adopted.error().code, adopted.error().message + "; --new moves it aside and starts anew"};
  if (fs::exists(directory / "result.json")) {
    std::cout << "primo: study " << study.id() << " is complete in " << directory.string()
              << "; --new starts it anew\n";
    return true;
  }
  std::cout << "primo: study " << study.id() << (*adopted == study::Adopted::resumed ? " goes on in " : " begins in ")
            << directory.string() << "\n";
  return false;
}

Status show(const fs::path& directory) {
  PRIMO_ASSIGN(const auto result, study::read_result(directory));
  std::cout << "\n" << study::summary(result);
  return success();
}

Status write_report(const fs::path& directory) {
  PRIMO_ASSIGN(const fs::path page, study::write_report(directory));
  std::cout << "report: " << page.string() << "\n";
  return success();
}

Status run(const Options& options) {
  PRIMO_ASSIGN(const auto study, study::load_study(options.file, options.set));
  PRIMO_ASSIGN(const fs::path directory, directory_of(options, study));
  if (!options.local) PRIMO_TRY(check_graph(options.run, study));
  PRIMO_ASSIGN(const bool complete, prepare(options, study, directory));
  if (!complete) {
    catch_interrupts();
    PRIMO_TRY(options.local ? run_locally(study, directory, options.threads)
                            : run_on_graph(options.run, study, directory));
  }
  PRIMO_TRY(show(directory));
  return options.no_report ? success() : write_report(directory);
}

/// A study that was interrupted says how to go on, and ends as shells say it.
int finish(const Options& options, const Status& status) {
  if (!status.ok() && interrupted()) {
    std::cout << "primo: stopped. The same command goes on from here: primo study run " << options.file << "\n";
    return kInterrupted;
  }
  return report(status);
}

}  // namespace

void add_study(CLI::App& app, int& exit) {
  const auto options = std::make_shared<Options>();
  auto* verb = app.add_subcommand("study", "studies: run one, show its result, write its report, compare and export");
  verb->require_subcommand(1);

  auto* run_verb =
      verb->add_subcommand("run", "runs a study, or goes on with it; then shows its result and writes its report");
  run_verb->add_option("file", options->file, "study file")->required();
  run_verb->add_option("--directory", options->directory, "of its journal, result and report (default: studies/NAME)");
  run_verb->add_option(
      "--set", options->set,
      "key=value in place of what the study file says, e.g. optimizer.evaluations=500; PART.key=value for one part");
  run_verb->add_flag("--local", options->local, "in this process, without the graph of services");
  run_verb->add_option("--threads", options->threads, "with --local; 0: one for each processor")
      ->check(CLI::Range(0, 1024));
  run_verb->add_flag("--new", options->anew, "moves the directory aside and starts anew");
  run_verb->add_flag("--no-report", options->no_report, "writes no report");
  run_verb->add_option("--run", options->run, "run-time folder of the graph");
  run_verb->callback([options, &exit] { exit = finish(*options, run(*options)); });

  auto* show_verb = verb->add_subcommand("show", "prints a study's rules, rates and precisions, before and after");
  show_verb->add_option("directory", options->directory, "of the study")->required();
  show_verb->callback([options, &exit] { exit = report(show(options->directory)); });

  auto* report_verb = verb->add_subcommand("report", "writes a study's report again");
  report_verb->add_option("directory", options->directory, "of the study")->required();
  report_verb->callback([options, &exit] { exit = report(write_report(options->directory)); });

  auto* diff_verb = verb->add_subcommand("diff", "prints in what two studies differ, and their results side by side");
  diff_verb->add_option("first", options->directory, "a study's directory, or a study file")->required();
  diff_verb->add_option("second", options->other, "the other")->required();
  diff_verb->callback([options, &exit] { exit = report(diff_studies(options->directory, options->other)); });

  auto* export_verb = verb->add_subcommand("export", "writes what a study has seen, for other programs");
  export_verb->add_option("directory", options->directory, "of the study")->required();
  export_verb->add_option("--format", options->format, "jsonl: experiences as JSON lines; csv: one line each")
      ->check(CLI::IsMember({"jsonl", "csv"}));
  export_verb->add_option("--out", options->file, "the file to write (default: standard output)");
  export_verb->callback(
      [options, &exit] { exit = report(export_experience(options->directory, options->format, options->file)); });
}

}  // namespace primo::tool
