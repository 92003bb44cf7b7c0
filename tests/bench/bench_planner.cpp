// Time and cost of plans of the hand-tuned grasp on seeded scenes with obstacles, by solver, start and number of steps.
//   bench_planner [--json] [--problems N] [--solver NAME]... [--random N]
// `cost_ratio` is the cost over the least that any solver and start found for the same problem. With --random, also
// plans N problems with every ρ drawn from 10^U(−3, 9) by each solver and counts what must never happen.
#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "bench/measure.h"
#include "core/random.h"
#include "motion/planner.h"

namespace {

using namespace primo;
using Json = nlohmann::ordered_json;

/// A target and three obstacles about it on the table.
scene::SceneEstimate make_scene(std::uint64_t seed) {
  Random random(seed, "bench_planner");
  scene::SceneEstimate scene;
  const Eigen::Vector3d target(random.uniform(0.7, 0.9), random.uniform(-0.15, 0.15), 0.724);
  const double angle = random.uniform(0, 2 * M_PI);
  for (int i = 0; i < 4; ++i) {
    const double direction = angle + 2.1 * i, away = i == 0 ? 0 : random.uniform(0.12, 0.16);
    scene::ObjectEstimate object;
    object.name = "c" + std::to_string(i + 1);
    object.shape = {ShapeType::cylinder, {0.0375, 0.054, 0}};
    object.X_WO = pose(Eigen::Vector3d(target + away * Eigen::Vector3d(std::cos(direction), std::sin(direction), 0)));
    scene.objects.push_back(object);
  }
  return scene;
}

bool converged(const motion::Plan& plan) {
  return plan.status == motion::PlanStatus::converged_step || plan.status == motion::PlanStatus::converged_cost;
}

struct Case {
  std::string solver, start;
  int steps = 0;
  std::vector<double> ms, iterations, cost, ratio;  ///< by problem
  int converged = 0;
};

struct Bench {
  const robot::Robot& robot;
  const motion::Primitive& primitive;
  std::vector<std::string> solvers;

  motion::PlanRequest request(std::uint64_t seed, const std::string& solver, const std::string& start,
                              int steps) const {
    motion::PlanRequest request;
    request.scene = make_scene(seed);
    request.action = {"grasp", "c1"};
    request.q_start.assign(robot.home().data(), robot.home().data() + robot.joints());
    request.primitive = primitive;
    request.primitive.solver = solver;
    request.primitive.start = start;
    request.primitive.steps = steps;
    return request;
  }

  std::vector<Case> run(int problems) const {
    std::vector<Case> cases;
    for (const auto& solver : solvers) {
      for (const std::string start : {"rest", "ik", "best"}) {
        for (const int steps : {32, 64, 100}) cases.push_back({solver, start, steps, {}, {}, {}, {}, 0});
      }
    }
    std::map<std::pair<int, int>, double> best;  // by steps and problem
    for (int problem = 0; problem < problems; ++problem) {
      for (auto& entry : cases) {
        const auto asked = request(static_cast<std::uint64_t>(problem), entry.solver, entry.start, entry.steps);
        const double before = bench::cpu_milliseconds();
        const auto plan = motion::plan(robot, asked);
        entry.ms.push_back(bench::cpu_milliseconds() - before);
        entry.iterations.push_back(plan.iterations + plan.rejected);
        entry.cost.push_back(plan.cost_final);
        entry.converged += converged(plan);
        // A path that had to keep hard constraints is no measure for those that need not.
        auto [at, fresh] = best.try_emplace({entry.steps, problem}, plan.cost_final);
        if (!fresh) at->second = std::min(at->second, plan.cost_final);
      }
      std::fprintf(stderr, "\rproblem %d of %d", problem + 1, problems);
    }
    std::fprintf(stderr, "\n");
    for (auto& entry : cases) {
      for (int problem = 0; problem < problems; ++problem)
        entry.ratio.push_back(entry.cost[static_cast<std::size_t>(problem)] / best[{entry.steps, problem}]);
    }
    return cases;
  }

  /// Counts of what planning random precisions gave.
  Json random(const std::string& solver, int count) const {
    int not_finite = 0, refused = 0, thrown = 0, good = 0;
    std::vector<double> ms;
    for (int i = 0; i < count; ++i) {
      Random random(10, "bench_planner rho", {static_cast<std::uint64_t>(i)});
      auto asked = request(static_cast<std::uint64_t>(i), solver, i % 4 ? "ik" : "rest", 64);
      std::vector<double> rho(primitive.log_rho().size());
      for (double& value : rho) value = random.uniform(-3, 9);
      asked.primitive = asked.primitive.with_log_rho(rho);
      try {
        const double before = bench::cpu_milliseconds();
        const auto plan = motion::plan(robot, asked);
        ms.push_back(bench::cpu_milliseconds() - before);
        refused += plan.status == motion::PlanStatus::bad_input;
        not_finite += !plan.trajectory.q.allFinite() || !std::isfinite(plan.cost_final);
        good += converged(plan);
      } catch (...) {
        ++thrown;
      }
    }
    return {{"solver", solver},
            {"plans", count},
            {"not_finite", not_finite},
            {"thrown", thrown},
            {"refused", refused},
            {"converged", good},
            {"ms_median", bench::quantile(ms, 0.5)},
            {"ms_90", bench::quantile(ms, 0.9)}};
  }
};

void print_table(const std::vector<Case>& cases) {
  std::printf("%-18s %-5s %4s %10s %10s %6s %12s %12s %10s\n", "solver", "start", "T", "ms median", "ms 90 %", "iter.",
              "cost/best 50", "cost/best 90", "converged");
  for (const auto& entry : cases) {
    std::printf("%-18s %-5s %4d %10.2f %10.2f %6.0f %12.3f %12.3f %6d/%zu\n", entry.solver.c_str(), entry.start.c_str(),
                entry.steps, bench::quantile(entry.ms, 0.5), bench::quantile(entry.ms, 0.9),
                bench::quantile(entry.iterations, 0.5), bench::quantile(entry.ratio, 0.5),
                bench::quantile(entry.ratio, 0.9), entry.converged, entry.ms.size());
  }
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app("Time and cost of plans of the hand-tuned grasp among obstacles, by solver, start and number of steps.");
  bool json = false;
  int problems = 40, random = 0;
  std::vector<std::string> solvers;
  app.add_flag("--json", json, "print JSON");
  app.add_option("--problems", problems, "seeded scenes")->check(CLI::Range(1, 10000))->capture_default_str();
  app.add_option("--solver", solvers, "only these");
  app.add_option("--random", random, "also so many plans with random precisions, by each solver")
      ->check(CLI::Range(0, 1000000));
  CLI11_PARSE(app, argc, argv);
  const std::filesystem::path configs = std::filesystem::path(PRIMO_SOURCE_DIR) / "configs";
  const auto robot = robot::Robot::load(configs / "robots/schunk_lwa3_sdh2.yaml");
  const auto primitive = motion::read_primitive(configs / "primitives/grasp_hand_tuned.yaml");
  if (!robot.ok() || !primitive.ok()) {
    std::fprintf(stderr, "%s\n", (robot.ok() ? primitive.error() : robot.error()).message.c_str());
    return 78;
  }
  if (solvers.empty()) {
    for (const auto& entry : motion::planners()) solvers.push_back(entry.name);
  }
  const Bench bench{*robot, *primitive, solvers};
  const auto cases = bench.run(problems);
  Json randoms = Json::array();
  for (const auto& solver : solvers) {
    if (random > 0) randoms.push_back(bench.random(solver, random));
  }
  const double memory = bench::peak_memory();
  if (!json) {
    print_table(cases);
    if (!randoms.empty()) std::printf("%s\n", randoms.dump(2).c_str());
    std::printf("peak memory %.0f MiB\n", memory);
    return 0;
  }
  Json rows = Json::array();
  for (const auto& entry : cases) {
    rows.push_back({{"solver", entry.solver},
                    {"T", entry.steps},
                    {"start", entry.start},
                    {"ms_median", bench::quantile(entry.ms, 0.5)},
                    {"ms_90", bench::quantile(entry.ms, 0.9)},
                    {"iterations_median", bench::quantile(entry.iterations, 0.5)},
                    {"cost_ratio_median", bench::quantile(entry.ratio, 0.5)},
                    {"cost_ratio_90", bench::quantile(entry.ratio, 0.9)},
                    {"converged", entry.converged},
                    {"problems", problems}});
  }
  std::printf("%s\n", Json{{"planner", rows}, {"random", randoms}, {"peak_memory_mib", memory}}.dump(2).c_str());
}
