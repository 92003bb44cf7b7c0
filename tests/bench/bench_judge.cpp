// What a judgement costs, by mode and stage, against bare mj_step on the same model and states, and how often a good
// hand-made grasp is held as the jiggle grows. Thread CPU time.
//   bench_judge [--json] [--runs N]
#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "bench/measure.h"
#include "bench/step_clock.h"
#include "motion/planner.h"
#include "physics/criteria.h"
#include "study/local_workers.h"
#include "study/rollout.h"
#include "unit/physics/grasp_fixture.h"
#include "unit/physics/place_fixture.h"

namespace {

using namespace primo;
using namespace primo::physics;
using Json = nlohmann::ordered_json;

constexpr double kPlaceSeconds = 4;  // of the published place

struct Timed {
  std::vector<double> ms;
  long steps = 0;
  Rate held;
};

Timed time_of(const Judge& judge, JudgeRequest request, int runs) {
  Timed timed;
  for (int k = -1; k < runs; ++k) {
    request.seed = static_cast<std::uint64_t>(k + 1);
    const double begin = bench::cpu_milliseconds();
    const auto verdict = judge.evaluate(request);
    const double ms = bench::cpu_milliseconds() - begin;
    PRIMO_CHECK(verdict.ok(), verdict.error().message);
    if (k < 0) continue;  // the first compiles the hand's model
    timed.ms.push_back(ms);
    timed.steps += verdict->steps;
    timed.held.add(verdict->final_pose_success);
  }
  return timed;
}

Json summary(const Timed& timed) {
  double total = 0;
  for (const double ms : timed.ms) total += ms;
  const auto runs = static_cast<double>(timed.ms.size());
  Json out = {{"median_ms", bench::median(timed.ms)}, {"runs", timed.ms.size()}, {"held", bench::json_of(timed.held)}};
  if (timed.steps > 0) {
    out["steps"] = static_cast<double>(timed.steps) / runs;
    out["steps_per_second"] = 1e3 * static_cast<double>(timed.steps) / total;
  }
  return out;
}

/// Also how much of the time is inside MuJoCo's steps, and what a bare mj_step costs from the same states.
Json against_bare_steps(const Judge& judge, const JudgeRequest& request, int runs) {
  const Timed timed = time_of(judge, request, runs);
  Json out = summary(timed);
  auto& clock = bench::step_clock;
  clock = {};
  const double begin = bench::StepClock::now();
  time_of(judge, request, runs);
  const double whole = bench::StepClock::now() - begin;
  out["share_inside_mj_step"] = clock.inside_ms / whole;
  clock = {};
  clock.replay_each = 7;
  time_of(judge, request, 1);
  const double bare = clock.replayed_ms / static_cast<double>(clock.replayed);
  const double steps = static_cast<double>(timed.steps) / static_cast<double>(timed.ms.size());
  out["bare_mj_step_us"] = 1e3 * bare;
  out["ratio_to_bare_mj_step"] = bench::median(timed.ms) / (steps * bare);
  clock = {};
  return out;
}

Json path_criteria(const robot::Robot& robot, const JudgeRequest& request) {
  std::vector<double> ms;
  for (int k = 0; k < 200; ++k) {
    const double begin = bench::cpu_milliseconds();
    evaluate_criteria({robot, request.scenario, "c1", request.q, request.dt, 0, request.settings});
    ms.push_back(bench::cpu_milliseconds() - begin);
  }
  return {{"median_ms", bench::median(ms)}, {"runs", ms.size()}};
}

void held_by_jiggle(const Judge& judge, const JudgeRequest& request, Json& out) {
  for (const double amplitude : {0.0, 0.5, 1.0, 1.5, 2.0, 3.0}) {
    JudgeRequest shaken = request;
    shaken.settings.jiggle_translation *= amplitude;
    shaken.settings.jiggle_rotation *= amplitude;
    out["held_by_amplitude"][std::to_string(amplitude).substr(0, 3)] = bench::json_of(time_of(judge, shaken, 40).held);
  }
  for (const double frequency : {2.0, 3.0, 4.0, 5.0}) {
    JudgeRequest shaken = request;
    shaken.settings.jiggle_frequency = frequency;
    out["held_by_frequency_hz"][std::to_string(frequency).substr(0, 3)] =
        bench::json_of(time_of(judge, shaken, 40).held);
  }
}

/// A place in both modes: without obstacles, and the training scenes with the reference's plans.
Json places(const robot::Robot& robot, const Judge& judge, int runs) {
  auto request = physics::testing::place_at(robot, {0, 0, 0});
  if (!request) return {{"error", "no place found"}};
  request->dt = kPlaceSeconds / static_cast<double>(request->q.rows() - 1);
  Json out;
  out["path_criteria"] = path_criteria(robot, *request);
  out["final_pose"] = against_bare_steps(judge, *request, runs);
  request->mode = Mode::execute;
  out["execute"] = against_bare_steps(judge, *request, runs / 4);
  const std::filesystem::path configs = std::filesystem::path(PRIMO_SOURCE_DIR) / "configs";
  const auto primitive = motion::read_primitive(configs / "primitives/place_reference.yaml");
  PRIMO_CHECK(primitive.ok(), primitive.error().message);
  for (int i = 1; i <= 6; ++i) {
    const std::string name = "place_" + std::to_string(i);
    auto scenario = scene::read_scenario(configs / "scenarios" / (name + ".yaml"));
    PRIMO_CHECK(scenario.ok(), scenario.error().message);
    auto estimate = study::observe_scenario(*scenario);
    PRIMO_CHECK(estimate.ok(), estimate.error().message);
    study::Rollout rollout{*scenario, *estimate, *primitive, 1, Mode::execute, {}};
    const auto plan = motion::plan(robot, study::plan_request(rollout));
    JudgeRequest trained = study::judge_request(rollout, plan);
    out[name]["objects"] = scenario->objects.size();
    out[name]["execute"] = against_bare_steps(judge, trained, runs / 8);
    trained.mode = Mode::final_pose;
    out[name]["final_pose"] = against_bare_steps(judge, trained, runs / 4);
  }
  return out;
}

}  // namespace

int main(int argc, char** argv) {
  int runs = 60;
  bool json = false, jiggles = true;
  CLI::App app{"cost of the judge"};
  app.add_option("--runs", runs, "final poses; a quarter as many executions")->check(CLI::Range(8, 100000));
  app.add_flag("--json", json, "one line of JSON instead of an indented one");
  app.add_flag("!--no-jiggles", jiggles, "leave out the rates by amplitude and frequency");
  CLI11_PARSE(app, argc, argv);
  const auto robot = physics::testing::load_robot();
  const Judge judge(robot);
  const auto scenario = physics::testing::one_cylinder();
  const auto good = physics::testing::hand_made_grasp(robot, scenario);
  const auto miss = physics::testing::hand_made_grasp(robot, scenario, {0, 0, -0.06});
  if (!good || !miss) return 1;
  Json out;
  const JudgeRequest request = physics::testing::request_for(scenario, *good);
  JudgeRequest executed = request;
  executed.mode = Mode::execute;
  out["final_pose"]["grasp"] = against_bare_steps(judge, request, runs);
  out["final_pose"]["grasp_without_contact"] =
      summary(time_of(judge, physics::testing::request_for(scenario, *miss), runs));
  out["execute"]["grasp"] = against_bare_steps(judge, executed, runs / 4);
  out["place"] = places(robot, judge, runs);
  out["path_criteria"] = path_criteria(robot, request);
  out["peak_memory_mb"] = bench::peak_memory();
  if (jiggles) held_by_jiggle(judge, request, out);
  std::puts(out.dump(json ? -1 : 2).c_str());
}
