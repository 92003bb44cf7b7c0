// What a judgement costs, by stage and mode, and how often a good hand-made grasp is held as the jiggle grows. Thread
// CPU time.
#include <time.h>

#include <algorithm>
#include <cstdio>
#include <nlohmann/json.hpp>

#include "physics/criteria.h"
#include "physics/place_trial.h"
#include "unit/physics/grasp_fixture.h"
#include "unit/physics/place_fixture.h"

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
  const double begin = cpu_ms();
  for (int k = 0; k < kSteps; ++k) mj_step(model, data);
  return (cpu_ms() - begin) / kSteps;
}

/// A place in both modes: milliseconds, steps a second, and the time of a step against a bare mj_step.
nlohmann::ordered_json places(const robot::Robot& robot, const Judge& judge) {
  auto request = physics::testing::place_at(robot, {0, 0, 0});
  if (!request) return {{"error", "no place found"}};
  nlohmann::ordered_json out;
  const double bare = bare_step_ms(robot, *request);
  out["bare_step_us"] = 1e3 * bare;
  for (const Mode mode : {Mode::final_pose, Mode::execute}) {
    request->mode = mode;
    auto row = time_of(judge, *request, mode == Mode::execute ? 10 : 40);
    const auto verdict = judge.evaluate(*request);
    if (!verdict.ok()) return {{"error", verdict.error().message}};
    const double ms = row.value("median_ms", 0.0);
    row["steps"] = verdict->steps;
    row["steps_per_s"] = 1e3 * verdict->steps / ms;
    if (mode == Mode::final_pose) row["ratio_to_bare_step"] = ms / verdict->steps / bare;
    out[config::enum_name(mode)] = row;
  }
  std::vector<double> path;
  for (int k = 0; k < 100; ++k) {
    const double begin = cpu_ms();
    evaluate_criteria({robot, request->scenario, "c1", request->q, request->dt, 0, request->settings});
    path.push_back(cpu_ms() - begin);
  }
  out["path_criteria"] = summary(path);
  return out;
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
  out["place"] = places(robot, judge);
  std::puts(out.dump(2).c_str());
}
