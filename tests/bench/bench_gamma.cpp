// Evaluations and rollouts until a study's optimizer reaches a success on its training scenes, over restarts: γ of the
// real planner and judge, in this process on one thread. Only the training scenes of the study are used.
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <ctime>
#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>

#include "study/journal.h"
#include "study/local_workers.h"
#include "study/optimization.h"
#include "study/study.h"

namespace {

namespace fs = std::filesystem;
using namespace primo;
using Json = nlohmann::ordered_json;

struct Options {
  std::string study = PRIMO_SOURCE_DIR "/configs/studies/grasp_quick.yaml";
  std::vector<std::string> set;
  int restarts = 3;
};

double cpu_seconds() {
  timespec time{};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &time);
  return static_cast<double>(time.tv_sec) + 1e-9 * static_cast<double>(time.tv_nsec);
}

/// Rolls out on the calling thread, and counts the CPU time of planner and judge.
class Serial : public study::Evaluator {
 public:
  explicit Serial(const study::LocalWorkers& workers) : workers_(workers) {}
  Status evaluate(std::span<const study::Rollout> rollouts,
                  const std::function<void(std::size_t, study::RolloutResult)>& on_result) override {
    if (enough) return Error{Code::unavailable, "enough"};
    for (std::size_t i = 0; i < rollouts.size(); ++i) {
      const double begin = cpu_seconds();
      auto result = workers_.roll_out(rollouts[i]);
      seconds += cpu_seconds() - begin;
      ++count;
      if (!result.ok()) return result.error();
      on_result(i, std::move(result).value());
    }
    return success();
  }
  bool enough = false;  ///< ends the search
  double seconds = 0;
  std::int64_t count = 0;

 private:
  const study::LocalWorkers& workers_;
};

/// The cost at which one restart first had a candidate with so many successes; the whole budget where it had none.
struct Reached {
  int evaluations = 0, rollouts = 0;
  bool hit = false;
};

Reached first_with(const std::vector<study::EvaluationRecord>& course, int successes) {
  Reached reached;
  for (const auto& e : course) {
    ++reached.evaluations;
    reached.rollouts += e.scenarios;
    reached.hit = e.successes >= successes;
    if (reached.hit) break;
  }
  return reached;
}

/// Mean and worst tenth over the restarts; one that did not reach it counts with all it spent.
Json summary(const std::vector<Reached>& runs) {
  std::vector<int> evaluations, rollouts;
  int hits = 0;
  for (const auto& run : runs) {
    evaluations.push_back(run.evaluations);
    rollouts.push_back(run.rollouts);
    hits += run.hit;
  }
  const auto numbers = [](std::vector<int> values) {
    std::sort(values.begin(), values.end());
    double sum = 0;
    for (const int v : values) sum += v;
    const auto worst = static_cast<std::size_t>(std::ceil(0.9 * static_cast<double>(values.size()))) - 1;
    return Json{{"mean", sum / static_cast<double>(values.size())}, {"worst_tenth", values[worst]}, {"all", values}};
  };
  return {{"reached", hits},
          {"restarts", runs.size()},
          {"evaluations", numbers(evaluations)},
          {"rollouts", numbers(rollouts)}};
}

/// The evaluations of one search, until a candidate succeeds in all scenes or the budget is spent.
Result<std::vector<study::EvaluationRecord>> course_of(const study::OptimizeGoal& goal, Serial& serial) {
  const fs::path directory = fs::temp_directory_path() / ("primo_bench_gamma_" + std::to_string(::getpid()));
  fs::create_directories(directory);
  serial.enough = false;
  const auto on_progress = [&](const study::Progress& p) {
    std::fprintf(stderr, "%-12s seed %llu %5d/%d  γ best %.3f mean %.3f  σ %.3f  success %s\n", p.algorithm.c_str(),
                 static_cast<unsigned long long>(goal.seed), p.done, p.total, p.best_gamma, p.mean_gamma, p.sigma,
                 p.success.text().c_str());
    serial.enough = p.success.trials > 0 && p.success.successes == p.success.trials;
  };
  std::vector<study::EvaluationRecord> course;
  {
    PRIMO_ASSIGN(auto journal, study::Journal::open(study::journal_file(directory)));
    const auto result = study::optimize(goal, serial, journal, on_progress);
    if (!result.ok() && !serial.enough) return result.error();
    PRIMO_ASSIGN(course, journal.evaluations());
  }
  std::error_code ignored;
  fs::remove_all(directory, ignored);
  return course;
}

Result<Json> measure(const Options& options) {
  PRIMO_ASSIGN(const auto loaded, study::load_study(options.study, options.set));
  study::LocalOptions local;
  local.threads = 1;
  PRIMO_ASSIGN(auto workers, study::LocalWorkers::create(loaded.robot, local));
  study::OptimizeGoal goal;
  goal.study = "bench-gamma";
  goal.primitive = loaded.parts[0].primitive;
  goal.scenarios = loaded.parts[0].training;
  PRIMO_ASSIGN(goal.estimates, workers->observe(loaded.parts[0].training));
  goal.desired = {{"inhand", {"X"}}};
  const auto& search = loaded.parts[0].settings.optimizer;
  goal.optimizer = search.of_optimizer();
  goal.judge = loaded.parts[0].settings.judge;
  auto settings = search.settings;
  settings.validation = 1;
  settings.sensitivity = 0;
  goal.settings = config::dump(settings);

  Serial serial(*workers);
  const double begin = cpu_seconds();
  std::map<std::string, std::map<int, std::vector<study::EvaluationRecord>>> courses;
  for (const auto& algorithm : search.algorithms) {
    for (int restart = 0; restart < options.restarts; ++restart) {
      goal.algorithms = {algorithm};
      goal.seed = loaded.parts[0].settings.seed + static_cast<std::uint64_t>(restart);
      PRIMO_ASSIGN(courses[algorithm][restart], course_of(goal, serial));
    }
  }

  const int scenes = static_cast<int>(goal.scenarios.size());
  Json results = Json::array();
  for (const auto& [algorithm, restarts] : courses) {
    std::vector<Reached> most, all;
    for (const auto& [restart, course] : restarts) {
      most.push_back(first_with(course, scenes - 1));
      all.push_back(first_with(course, scenes));
    }
    results.push_back({{"algorithm", algorithm}, {"all_but_one", summary(most)}, {"all_scenes", summary(all)}});
  }
  const double seconds = cpu_seconds() - begin;
  return Json{{"bench", "gamma"},
              {"study", loaded.name},
              {"set", options.set},
              {"scenes", scenes},
              {"budget", search.evaluations},
              {"rollouts", serial.count},
              {"cpu_seconds", seconds},
              {"share_outside_planning_and_judging", 1 - serial.seconds / seconds},
              {"results", results}};
}

}  // namespace

int main(int argc, char** argv) {
  Options options;
  CLI::App app{"Rollouts until a success on the training scenes of a study"};
  app.add_option("--study", options.study, "study file")->capture_default_str();
  app.add_option("--set", options.set, "key=value of the study file, e.g. optimizer.racing.rounds=[2,4]");
  app.add_option("--restarts", options.restarts, "random starts of each algorithm, with seeds from the study's on")
      ->capture_default_str();
  CLI11_PARSE(app, argc, argv);
  const auto result = measure(options);
  if (!result.ok()) {
    std::fprintf(stderr, "bench_gamma: %s\n", result.error().message.c_str());
    return 1;
  }
  std::puts(result->dump(1).c_str());
}
