// Time and cost of plans of the hand-tuned grasp on seeded scenes with two obstacles, by planner and number of steps.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <ctime>
#include <filesystem>
#include <string>
#include <vector>

#include "core/random.h"
#include "motion/planner.h"

namespace {

using namespace primo;

double thread_milliseconds() {
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return 1e3 * static_cast<double>(now.tv_sec) + 1e-6 * static_cast<double>(now.tv_nsec);
}

scene::SceneEstimate make_scene(std::uint64_t seed) {
  Random random(seed, "bench_planner");
  scene::SceneEstimate scene;
  const Eigen::Vector3d target(random.uniform(0.7, 0.9), random.uniform(-0.15, 0.15), 0.724);
  const double angle = random.uniform(0, 2 * M_PI);
  for (int i = 0; i < 3; ++i) {
    const double direction = angle + 2.1 * i, away = i == 0 ? 0 : random.uniform(0.12, 0.16);
    scene::ObjectEstimate object;
    object.name = "c" + std::to_string(i + 1);
    object.shape = {ShapeType::cylinder, {0.0375, 0.054, 0}};
    object.X_WO = pose(Eigen::Vector3d(target + away * Eigen::Vector3d(std::cos(direction), std::sin(direction), 0)));
    scene.objects.push_back(object);
  }
  return scene;
}

double quantile(std::vector<double> values, double fraction) {
  std::sort(values.begin(), values.end());
  return values[static_cast<std::size_t>(fraction * static_cast<double>(values.size() - 1))];
}

}  // namespace

int main() {
  const std::filesystem::path configs = std::filesystem::path(PRIMO_SOURCE_DIR) / "configs";
  const auto robot = robot::Robot::load(configs / "robots/schunk_lwa3_sdh2.yaml");
  const auto primitive = motion::read_primitive(configs / "primitives/grasp_hand_tuned.yaml");
  if (!robot.ok() || !primitive.ok()) {
    std::fprintf(stderr, "%s\n", (robot.ok() ? primitive.error() : robot.error()).message.c_str());
    return 78;
  }
  std::printf("{\"planner\": [");
  bool first = true;
  for (const auto& entry : motion::planners()) {
    for (const std::string start : {"rest", "ik"}) {
      for (const int steps : {32, 64, 100}) {
        std::vector<double> ms, iterations, cost;
        for (std::uint64_t seed = 0; seed < 100; ++seed) {
          motion::PlanRequest request;
          request.scene = make_scene(seed);
          request.action = {"grasp", "c1"};
          request.q_start.assign(robot->home().data(), robot->home().data() + robot->joints());
          request.primitive = *primitive;
          request.primitive.solver = entry.name;
          request.primitive.start = start;
          request.primitive.steps = steps;
          const double before = thread_milliseconds();
          const auto plan = motion::plan(*robot, request);
          ms.push_back(thread_milliseconds() - before);
          iterations.push_back(plan.iterations + plan.rejected);
          cost.push_back(plan.cost_final);
        }
        std::printf(
            "%s\n  {\"solver\": \"%s\", \"start\": \"%s\", \"T\": %d, \"ms_median\": %.3f, \"ms_90\": %.3f, "
            "\"iterations_median\": %.0f, \"cost_median\": %.4f}",
            first ? "" : ",", entry.name.c_str(), start.c_str(), steps, quantile(ms, 0.5), quantile(ms, 0.9),
            quantile(iterations, 0.5), quantile(cost, 0.5));
        first = false;
      }
    }
  }
  std::printf("\n]}\n");
}
