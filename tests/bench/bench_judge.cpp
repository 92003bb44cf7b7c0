// What a judgement costs, by mode and stage, against bare mj_step on the same model and states, and how often a good
// hand-made grasp is held as the jiggle grows. Thread CPU time.
//   bench_judge [--json] [--runs N]
#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <nlohmann/json.hpp>

#include "bench/measure.h"
#include "physics/criteria.h"
#include "physics/execution.h"
#include "physics/place_trial.h"
#include "unit/physics/grasp_fixture.h"
#include "unit/physics/place_fixture.h"

namespace {

using namespace primo;
using namespace primo::physics;
using Json = nlohmann::ordered_json;

/// Milliseconds of a bare mj_step, by the states it starts from.
struct BareStep {
  double ms = 0;
  int steps = 0;
  void run(const mjModel* model, mjData* data, int count) {
    const double begin = bench::cpu_milliseconds();
    for (int k = 0; k < count; ++k) mj_step(model, data);
    ms += bench::cpu_milliseconds() - begin;
    steps += count;
  }
  double each() const { return ms / steps; }
};

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

/// With the cost of as many bare steps: `bare` is that of one.
Json against(const Timed& timed, const BareStep& bare) {
  Json out = summary(timed);
  const double steps = static_cast<double>(timed.steps) / static_cast<double>(timed.ms.size());
  out["bare_step_us"] = 1e3 * bare.each();
  out["ratio_to_bare_mj_step"] = bench::median(timed.ms) / (steps * bare.each());
  out["share_of_mj_step"] = steps * bare.each() / bench::median(timed.ms);
  return out;
}

/// The hand's model from the states of a trial: closing on the pinned object, and holding it.
BareStep bare_hand_steps(const robot::Robot& robot, const JudgeRequest& request) {
  auto whole = robot_model(robot);
  PRIMO_CHECK(whole.ok(), whole.error().message);
  const scene::Object& object = request.scenario.objects[0];
  auto workspace = HandWorkspace::create(robot, whole->get(), object.shape(), object.mass, request.settings.timestep);
  PRIMO_CHECK(workspace.ok(), workspace.error().message);
  const Eigen::VectorXd q = request.q.bottomRows(1).transpose();
  const Pose X_WP = robot.forward(q).X_WB[static_cast<std::size_t>(robot.chain()[robot.arm_joints() - 1].body)];
  BareStep bare;
  mjModel* model = workspace->model.get();
  mjData* data = workspace->data.get();
  for (std::uint64_t seed = 0; seed < 10; ++seed) {
    const auto trial = run_trial(robot, *workspace, q, X_WP, object.X_WO(), 0, request.settings, seed);
    const int closing = static_cast<int>(request.settings.close_seconds / request.settings.timestep);
    // As the trial left it: held, with the torques and forces of its last step.
    bare.run(model, data, trial.steps - closing);
    // As it began: fingers closing in the air, then onto an object as heavy as a building.
    mj_resetData(model, data);
    workspace->joints.set(data, q);
    set_free_joint(model, data, workspace->object_joint, X_WP.inverse(Eigen::Isometry) * object.X_WO());
    workspace->pin.hold(model, data);
    workspace->joints.close(robot, data, q.tail(robot.hand_joints()));
    bare.run(model, data, closing);
  }
  return bare;
}

/// The whole scene's model from states all along an execution.
BareStep bare_scene_steps(const robot::Robot& robot, const JudgeRequest& request) {
  Recording recording;
  const auto verdict = Judge(robot).evaluate(request, &recording);
  PRIMO_CHECK(verdict.ok(), verdict.error().message);
  auto model = assemble(&robot, request.scenario, {.timestep = request.settings.timestep, .extra = {}});
  PRIMO_CHECK(model.ok(), model.error().message);
  (*model)->opt.disableflags |= mjDSBL_ACTUATION;
  Data data(*model);
  const JointMap joints(robot, model->get());
  BareStep bare;
  for (const auto& frame : recording.frames) {
    mj_resetData(model->get(), data.get());
    joints.set(data.get(), frame.q);
    for (std::size_t i = 0; i < frame.X_WO.size(); ++i)
      set_free_joint(model->get(), data.get(), model->joint(request.scenario.objects[i].name), frame.X_WO[i]);
    mj_forward(model->get(), data.get());
    std::copy_n(data->qfrc_bias, (*model)->nv, data->qfrc_applied);
    for (int i = 0; i < (*model)->njnt; ++i) {
      if ((*model)->jnt_type[i] == mjJNT_FREE) std::fill_n(data->qfrc_applied + (*model)->jnt_dofadr[i], 6, 0.0);
    }
    for (int k = 0; k < 5; ++k) mj_step(model->get(), data.get());  // the solver starts warm in an execution, too
    bare.run(model->get(), data.get(), 10);
  }
  return bare;
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

/// Milliseconds of one bare mj_step of the place's model, several contacts a pair, with c1 standing on its support and
/// the open hand around it, no joint driven.
double bare_step_ms(const robot::Robot& robot, const JudgeRequest& request) {
  const auto whole = robot_model(robot);
  if (!whole.ok()) return 0;
  const auto hand = hand_mjcf(robot, whole->get());
  auto made = hand.ok() ? PlaceWorkspace::create(robot, *hand, request.scenario, request.settings.timestep)
                        : Result<PlaceWorkspace>(hand.error());
  if (!made.ok()) return 0;
  mjModel* model = made->model.get();
  mjData* data = made->data.get();
  model->opt.enableflags |= mjENBL_MULTICCD;
  const Eigen::VectorXd q = request.q.bottomRows(1).transpose();
  const robot::Kinematics kinematics = robot.forward(q);
  const Pose& X_WP = kinematics.X_WB[static_cast<std::size_t>(robot.body("palm"))];
  const Eigen::Quaterniond R = quaternion(X_WP);
  for (int i = 0; i < 3; ++i) model->body_pos[3 * made->hand_body + i] = X_WP.translation()[i];
  const double wxyz[4] = {R.w(), R.x(), R.y(), R.z()};
  std::copy(wxyz, wxyz + 4, model->body_quat + 4 * made->hand_body);
  mj_resetData(model, data);
  made->joints.set(data, robot.home());
  for (const auto& object : request.scenario.objects)
    set_free_joint(model, data, made->model.joint(object.name), object.X_WO());
  set_free_joint(model, data, made->model.joint("c1"), pose(testing::top_of_support(request.scenario)));
  constexpr int kSteps = 2000;
  const double begin = bench::cpu_milliseconds();
  for (int k = 0; k < kSteps; ++k) mj_step(model, data);
  return (bench::cpu_milliseconds() - begin) / kSteps;
}

/// A place in both modes against bare steps of its model.
Json places(const robot::Robot& robot, const Judge& judge) {
  auto request = physics::testing::place_at(robot, {0, 0, 0});
  if (!request) return {{"error", "no place found"}};
  BareStep bare;
  bare.ms = bare_step_ms(robot, *request);
  bare.steps = 1;
  Json out;
  out["final_pose"] = against(time_of(judge, *request, 40), bare);
  request->mode = Mode::execute;
  out["execute"] = summary(time_of(judge, *request, 10));
  out["path_criteria"] = path_criteria(robot, *request);
  return out;
}

}  // namespace

int main(int argc, char** argv) {
  int runs = 60;
  bool json = false, jiggles = true;
  CLI::App app{"cost of the judge"};
  app.add_option("--runs", runs, "final poses; a quarter as many executions")->check(CLI::Range(4, 100000));
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
  out["final_pose"]["grasp"] = against(time_of(judge, request, runs), bare_hand_steps(robot, request));
  out["final_pose"]["grasp_without_contact"] =
      summary(time_of(judge, physics::testing::request_for(scenario, *miss), runs));
  out["execute"]["grasp"] = against(time_of(judge, executed, runs / 4), bare_scene_steps(robot, executed));
  out["place"] = places(robot, judge);
  out["path_criteria"] = path_criteria(robot, request);
  out["peak_memory_mb"] = bench::peak_memory();
  if (jiggles) held_by_jiggle(judge, request, out);
  std::puts(out.dump(json ? -1 : 2).c_str());
}
