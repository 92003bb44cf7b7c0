#include "primo/study_graph.h"

#include <primo_study.h>
#include <spdlog/spdlog.h>
#include <unistd.h>

#include <chrono>
#include <deque>
#include <map>
#include <mutex>
#include <thread>

#include "bus/latched.h"
#include "bus/status.h"
#include "common/assignment.h"
#include "primo/graph/supervisor.h"
#include "primo/interrupt.h"
#include "primo/progress_lines.h"

namespace primo::tool {
namespace {

namespace fs = std::filesystem;
using Clock = std::chrono::steady_clock;
using primo_msgs::msg::Progress;

/// Progress samples on their way from the bus to the terminal.
class Samples {
 public:
  void put(Progress&& sample) {
    const std::lock_guard lock(mutex_);
    samples_.push_back(std::move(sample));
  }
  std::deque<Progress> take() {
    const std::lock_guard lock(mutex_);
    return std::exchange(samples_, {});
  }

 private:
  std::mutex mutex_;
  std::deque<Progress> samples_;
};

StageState state_of(const Progress& sample) {
  StageState state;
  state.part = sample.part();
  state.round = sample.round();
  state.stage = sample.stage();
  state.subject = sample.algorithm().empty() ? sample.text() : sample.algorithm();
  state.done = sample.done();
  state.total = sample.total();
  state.rate = sample.rate();
  state.seconds_left = sample.seconds_left();
  state.searching = sample.stage() == "optimize";
  state.best_gamma = sample.best_gamma();
  state.mean_gamma = sample.mean_gamma();
  state.sigma = sample.sigma();
  state.condition = sample.condition();
  state.success = {sample.success().successes(), sample.success().trials()};
  state.finished = sample.finished();
  return state;
}

/// Says what the conductor and the optimizer wait for, when that lasts.
class WaitingReporter {
 public:
  void look(const bus::StatusWatcher& watcher, ProgressLines& lines) {
    for (const char* role : {"conductor", "optimizer"}) {
      auto& [text, since, said] = roles_[role];
      std::string now_waiting;
      for (const auto& worker : watcher.workers(role)) now_waiting = worker.waiting_for;
      if (now_waiting != text) {
        text = now_waiting;
        since = Clock::now();
        said = false;
      }
      if (!text.empty() && !said && Clock::now() - since > std::chrono::seconds(2)) {
        lines.say(std::string("primo: ") + role + " waits for " + text);
        said = true;
      }
    }
  }

 private:
  struct State {
    std::string text;
    Clock::time_point since{};
    bool said = false;
  };
  std::map<std::string, State> roles_;
};

/// Shows progress until the conductor has written what became of the assignment.
Status follow(const Layout& layout, const std::string& study_id, const std::string& assignment, Samples& samples,
              const bus::StatusWatcher& watcher) {
  ProgressLines lines;
  WaitingReporter waiting;
  for (;; std::this_thread::sleep_for(std::chrono::milliseconds(200))) {
    const auto outcome = graph::read_outcome(layout.run);
    for (const auto& sample : samples.take()) {
      if (sample.study() == study_id && sample.stage() != "done") lines.show(state_of(sample));
    }
    if (outcome.ok() && *outcome && (*outcome)->id == assignment) {
      lines.close();
      if ((*outcome)->exit == 0) return success();
      for (const Code code : {Code::config, Code::unavailable, Code::internal, Code::usage}) {
        if (exit_code(code) == (*outcome)->exit) return Error{code, (*outcome)->message};
      }
      return Error{Code::failed, (*outcome)->message};
    }
    waiting.look(watcher, lines);
    if (interrupted()) {
      lines.close();
      PRIMO_TRY(graph::withdraw_assignment(layout.run));
      return Error{Code::failed, "interrupted"};
    }
    if (!supervisor_pid(layout)) {
      lines.close();
      return Error{Code::unavailable,
                   "the graph went down; primo up starts it, and the same command goes on with the study"};
    }
  }
}

}  // namespace

Status check_graph(const std::string& run, const study::Study& study) {
  PRIMO_ASSIGN(const Layout layout, find_layout(run));
  if (!supervisor_pid(layout)) {
    return Error{Code::unavailable, "no graph is up in " + layout.run.string() +
                                        "; start it with primo up, or run the study in one process with --local"};
  }
  if (fs::weakly_canonical(study.robot) != fs::weakly_canonical(layout.robot)) {
    return Error{Code::config, "the graph was started for the robot " + layout.robot.string() +
                                   ", but the study is for " + study.robot + "; start it with primo up --robot " +
                                   study.robot};
  }
  return success();
}

Status run_on_graph(const std::string& run, const study::Study& study, const fs::path& directory) {
  PRIMO_ASSIGN(const Layout layout, find_layout(run));
  spdlog::set_level(spdlog::level::err);
  bus::BusSettings bus;
  bus.domain_override = layout.domain;
  PRIMO_ASSIGN(const auto participant, bus::Participant::create(bus, "primo_study"));
  PRIMO_ASSIGN(const auto watcher, bus::StatusWatcher::create(participant));
  Samples samples;
  PRIMO_ASSIGN(const auto subscription,
               bus::Subscription<Progress>::create(participant, topics::kProgress,
                                                   [&](Progress&& sample) { samples.put(std::move(sample)); }));
  // What is latched already tells of an earlier run.
  watcher->wait_for("conductor", 1, std::chrono::seconds(5));
  std::this_thread::sleep_for(std::chrono::milliseconds(300));
  samples.take();

  const auto now = std::chrono::system_clock::now().time_since_epoch();
  const graph::Assignment assignment{study.id() + "-" + std::to_string(::getpid()) + "-" + std::to_string(now.count()),
                                     directory.string()};
  PRIMO_TRY(graph::write_assignment(layout.run, assignment));
  return follow(layout, study.id(), assignment.id, samples, *watcher);
}

}  // namespace primo::tool
