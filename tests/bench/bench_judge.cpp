// What a judgement costs, by stage and mode, and how often a good hand-made grasp is held as the jiggle grows. Thread
// CPU time.
#include <time.h>

#include <algorithm>
#include <cstdio>
#include <nlohmann/json.hpp>

#include "physics/criteria.h"
#include "unit/physics/grasp_fixture.h"

namespace {

using namespace primo;
using namespace primo::physics;

double cpu_ms() {
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return 1e3 * static_cast<double>(now.tv_sec) + 1e-6 * static_cast<double>(now.tv_nsec);
}

nlohmann::ordered_json summary(std::vector<double> ms) {
  std::sort(ms.begin(), ms.end());
  return {{"median_ms", ms[ms.size() / 2]}, {"p90_ms", ms[ms.size() * 9 / 10]}, {"runs", ms.size()}};
}

nlohmann::ordered_json time_of(const Judge& judge, JudgeRequest request, int runs) {
  std::vector<double> ms;
  int held = 0;
  for (int k = -1; k < runs; ++k) {
    request.seed = static_cast<std::uint64_t>(k + 1);
    const double begin = cpu_ms();
    const auto verdict = judge.evaluate(request);
    if (!verdict.ok()) return {{"error", verdict.error().message}};
    if (k < 0) continue;  // the first compiles the hand's model
    ms.push_back(cpu_ms() - begin);
    held += verdict->final_pose_success;
  }
  auto result = summary(ms);
  result["held"] = static_cast<double>(held) / runs;
  return result;
}

}  // namespace

int main() {
  const auto robot = physics::testing::load_robot();
  const Judge judge(robot);
  const auto scenario = physics::testing::one_cylinder();
  const auto good = physics::testing::hand_made_grasp(robot, scenario);
  const auto miss = physics::testing::hand_made_grasp(robot, scenario, {0, 0, -0.06});
  if (!good || !miss) return 1;
  nlohmann::ordered_json out;
  JudgeRequest request = physics::testing::request_for(scenario, *good);
  out["final_pose_held"] = time_of(judge, request, 60);
  out["final_pose_no_contact"] = time_of(judge, physics::testing::request_for(scenario, *miss), 60);
  request.mode = Mode::execute;
  out["execute_held"] = time_of(judge, request, 15);
  request.mode = Mode::final_pose;
  std::vector<double> path;
  for (int k = 0; k < 200; ++k) {
    const double begin = cpu_ms();
    evaluate_criteria({robot, scenario, "c1", request.q, request.dt, 0, request.settings});
    path.push_back(cpu_ms() - begin);
  }
  out["path_criteria"] = summary(path);
  for (const double amplitude : {0.0, 0.5, 1.0, 1.5, 2.0, 3.0}) {
    JudgeRequest shaken = request;
    shaken.settings.jiggle_translation *= amplitude;
    shaken.settings.jiggle_rotation *= amplitude;
    out["held_by_amplitude"][std::to_string(amplitude).substr(0, 3)] = time_of(judge, shaken, 40)["held"];
  }
  for (const double frequency : {2.0, 3.0, 4.0, 5.0}) {
    JudgeRequest shaken = request;
    shaken.settings.jiggle_frequency = frequency;
    out["held_by_frequency_hz"][std::to_string(frequency).substr(0, 3)] = time_of(judge, shaken, 40)["held"];
  }
  std::puts(out.dump(2).c_str());
}
