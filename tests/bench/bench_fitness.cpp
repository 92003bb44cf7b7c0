// How soon a search finds a primitive that succeeds in 5 and in all 6 training scenes, by the fitness that it climbs.
//   bench_fitness [--evaluations N] [--seeds N] [--population N] [--seconds N] [--only NAME]...
// CMA-ES over the hand-tuned grasp's open precisions from random starts, on the training scenarios alone; for each
// candidate all scenes with the same jiggles. Fitnesses and seeds take turns, so that a run cut short compares them
// fairly.
#include <CLI/CLI.hpp>
#include <array>
#include <chrono>
#include <cstdio>
#include <ctime>
#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>

#include "core/random.h"
#include "study/fitness.h"
#include "study/local_workers.h"

namespace {

using namespace primo;
using Json = nlohmann::ordered_json;
namespace fs = std::filesystem;

struct Training {
  std::vector<scene::Scenario> scenarios;
  std::vector<scene::SceneEstimate> estimates;
  motion::Primitive primitive;
};

template <class T>
T must(Result<T> result) {
  PRIMO_CHECK(result.ok(), result.error().message);
  return std::move(*result);
}

Training training(const robot::Robot& robot) {
  const fs::path configs = fs::path(PRIMO_SOURCE_DIR) / "configs";
  Training set;
  set.primitive = must(motion::read_primitive(configs / "primitives/grasp_hand_tuned.yaml"));
  for (int k = 1; k <= 6; ++k) {
    auto scenario = must(scene::read_scenario(configs / "scenarios" / ("grasp_" + std::to_string(k) + ".yaml")));
    if (scenario.robot_start.empty()) scenario.robot_start.assign(robot.home().begin(), robot.home().end());
    set.estimates.push_back(must(study::observe_scenario(scenario)));
    set.scenarios.push_back(std::move(scenario));
  }
  return set;
}

/// When a search first had a candidate with this many successes, in evaluations; 0: never.
struct Course {
  std::map<int, int> first;
  int evaluations = 0, best = 0, mean_of_end = 0;
  double seconds = 0;
};

double cpu_seconds() { return static_cast<double>(std::clock()) / CLOCKS_PER_SEC; }

struct Scored {
  double gamma = 0;
  int successes = 0;
};

Scored score(const study::LocalWorkers& workers, const Training& set, const std::vector<double>& x,
             const study::FitnessSettings& settings, std::uint64_t seed) {
  const std::vector<symbols::Literal> desired = {{"inhand", {"X"}}};
  const motion::Primitive primitive = set.primitive.with_log_rho(x);
  Scored scored;
  for (std::size_t k = 0; k < set.scenarios.size(); ++k) {
    const study::Rollout rollout{set.scenarios[k],
                                 set.estimates[k],
                                 primitive,
                                 Random(seed, "jiggle of the bench", {k}).bits(),
                                 physics::Mode::final_pose,
                                 {}};
    const auto result = must(workers.roll_out(rollout));
    const bool success = study::succeeded(result, desired, set.scenarios[k].action);
    scored.successes += success;
    scored.gamma += study::trajectory_fitness(result, success, settings) / static_cast<double>(set.scenarios.size());
  }
  return scored;
}

Course search(const study::LocalWorkers& workers, const Training& set, const study::FitnessSettings& settings,
              optim::OptimizerSettings search_settings) {
  const std::size_t n = set.primitive.log_rho().size();
  auto optimizer =
      must(optim::make_optimizer(search_settings, {std::vector<double>(n, -3.0), std::vector<double>(n, 9.0)}));
  Course course;
  const double begin = cpu_seconds();
  while (!optimizer->done() && course.best < 6) {
    for (const auto& candidate : optimizer->ask()) {
      const auto scored =
          score(workers, set, candidate.x, settings,
                Random(search_settings.seed, "generation", {static_cast<std::uint64_t>(candidate.generation)}).bits());
      ++course.evaluations;
      if (scored.successes > course.best) {
        for (int level = course.best + 1; level <= scored.successes; ++level) course.first[level] = course.evaluations;
        course.best = scored.successes;
      }
      const auto told = optimizer->tell(candidate.generation, candidate.index, scored.gamma);
      PRIMO_CHECK(told.ok(), told.error().message);
    }
  }
  // What the search would hand over: the mean of its distribution, with jiggles of its own.
  course.mean_of_end =
      score(workers, set, optimizer->recommendation(), settings, Random(search_settings.seed, "end").bits()).successes;
  course.seconds = cpu_seconds() - begin;
  return course;
}

Json json_of(std::uint64_t seed, const Course& course) {
  const auto first = [&](int level) { return course.first.contains(level) ? Json(course.first.at(level)) : Json(); };
  return {{"seed", seed},
          {"evaluations", course.evaluations},
          {"to_3", first(3)},
          {"to_5", first(5)},
          {"to_6", first(6)},
          {"best", course.best},
          {"mean_of_end", course.mean_of_end},
          {"cpu_s", course.seconds}};
}

}  // namespace

int main(int argc, char** argv) {
  optim::OptimizerSettings settings;
  settings.evaluations = 400;
  settings.population = 18;
  int seeds = 3;
  double seconds = 900;
  std::vector<std::string> only;
  CLI::App app{"fitnesses compared by the searches that climb them"};
  app.add_option("--evaluations", settings.evaluations, "budget of a search")->check(CLI::Range(18, 100000));
  app.add_option("--population", settings.population, "")->check(CLI::Range(4, 1000));
  app.add_option("--seeds", seeds, "searches a fitness")->check(CLI::Range(1, 1000));
  app.add_option("--seconds", seconds, "of CPU, after which no search begins")->check(CLI::Range(1.0, 1e6));
  app.add_option("--only", only, "fitnesses to compare");
  CLI11_PARSE(app, argc, argv);

  study::FitnessSettings separate, clean, both;
  separate.clean_share = separate.near = 0;
  clean.clean_share = 0.8;
  clean.near = 0;
  both.clean_share = 0.8;
  both.near = 0.1;
  const std::array<std::pair<std::string, study::FitnessSettings>, 3> fitnesses = {
      {{"separate", separate}, {"clean_score", clean}, {"clean_score_and_near", both}}};
  const auto workers = must(
      study::LocalWorkers::create(fs::path(PRIMO_SOURCE_DIR) / "configs/robots/schunk_lwa3_sdh2.yaml", {.threads = 1}));
  const Training set = training(workers->robot());
  Json out;
  const double begin = cpu_seconds();
  for (int seed = 1; seed <= seeds; ++seed) {
    for (const auto& [name, fitness] : fitnesses) {
      if (!only.empty() && std::find(only.begin(), only.end(), name) == only.end()) continue;
      if (cpu_seconds() - begin > seconds) continue;
      settings.seed = static_cast<std::uint64_t>(seed);
      const Json row = json_of(settings.seed, search(*workers, set, fitness, settings));
      std::fprintf(stderr, "%s %s\n", name.c_str(), row.dump().c_str());
      out[name].push_back(row);
    }
  }
  std::puts(out.dump(2).c_str());
}
