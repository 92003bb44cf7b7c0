// primo plan, judge, rollout: one scenario in this process: see it, plan in what is seen, judge in what is true.
#include "study/rollout.h"

#include <chrono>
#include <iostream>
#include <memory>
#include <optional>

#include "core/files.h"
#include "motion/measures.h"
#include "motion/planner.h"
#include "motion/start.h"
#include "physics/judge.h"
#include "physics/movie.h"
#include "physics/picture.h"
#include "primo/layout.h"
#include "primo/trajectory_json.h"
#include "primo/verbs.h"
#include "scene/reach.h"
#include "study/local_workers.h"

namespace primo::tool {
namespace {

struct Options {
  std::string scenario, robot, primitive, solver, start, trajectory, output, picture, movie, compare,
      mode = "final_pose";
  int survival = 0;        // jiggles at each amplitude of the survival table
  int max_iterations = 0;  // 0: the primitive's
  std::uint64_t seed = 1;
  bool json = false;
};

/// What all three verbs begin with. The scenario has its robot_start filled in.
struct Ground {
  robot::Robot robot;
  scene::Scenario scenario;
};

/// A plan with what it was made from.
struct Planned {
  study::Rollout rollout;
  motion::Plan plan;
  double milliseconds = 0;  ///< of planning alone
};

double milliseconds_since(std::chrono::steady_clock::time_point begin) {
  return std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - begin).count();
}

Result<Ground> prepare(const Options& options) {
  std::filesystem::path file = options.robot;
  if (file.empty()) {
    PRIMO_ASSIGN(const Layout layout, find_layout());
    file = layout.robot;
  }
  PRIMO_ASSIGN(auto robot, robot::Robot::load(file));
  PRIMO_ASSIGN(auto scenario, scene::read_scenario(options.scenario));
  if (scenario.robot_start.empty()) scenario.robot_start.assign(robot.home().begin(), robot.home().end());
  if (const auto status = scene::check_robot(scenario, robot); !status.ok()) return status.error().at(options.scenario);
  return Ground{std::move(robot), std::move(scenario)};
}

Result<motion::Primitive> primitive_of(const Options& options, const std::string& action) {
  std::filesystem::path file = options.primitive;
  if (file.empty()) {
    PRIMO_ASSIGN(const Layout layout, find_layout());
    file = layout.root / "configs" / "primitives" / (action + "_hand_tuned.yaml");
  }
  PRIMO_ASSIGN(auto primitive, motion::read_primitive(file));
  if (!options.solver.empty()) primitive.solver = options.solver;
  if (!options.start.empty()) primitive.start = options.start;
  if (options.max_iterations > 0) primitive.max_iterations = options.max_iterations;
  return primitive;
}

physics::Mode mode_of(const Options& options) {
  return options.mode == "execute" ? physics::Mode::execute : physics::Mode::final_pose;
}

/// Sees the scenario and plans in what is seen.
Result<Planned> plan_in(const Options& options, const Ground& ground) {
  Planned planned;
  study::Rollout& rollout = planned.rollout;
  rollout.scenario = ground.scenario;
  PRIMO_ASSIGN(rollout.primitive, primitive_of(options, ground.scenario.action[0]));
  PRIMO_ASSIGN(rollout.estimate, study::observe_scenario(ground.scenario));
  rollout.judge_seed = options.seed;
  rollout.mode = mode_of(options);
  rollout.judge.survival_seeds = options.survival;
  auto request = study::plan_request(rollout);
  request.want_gains = request.want_gains || !options.output.empty();
  const auto begin = std::chrono::steady_clock::now();
  planned.plan = motion::plan(ground.robot, request);
  planned.milliseconds = milliseconds_since(begin);
  return planned;
}

void print(const Options& options, const nlohmann::ordered_json& json, const std::string& sentence) {
  std::cout << (options.json ? json.dump() : sentence) << "\n";
}

/// The motion of a trajectory file, of this robot.
Result<motion::Plan> read_trajectory(const std::string& file, const robot::Robot& robot) {
  PRIMO_ASSIGN(const std::string text, read_file(file));
  auto plan = plan_from_json(text);
  if (!plan.ok()) return plan.error().at(file);
  if (plan->trajectory.joints != robot.joint_names()) {
    return Error{Code::data, file + ": its joints are not those of " + robot.name() + " in its robot file's order"};
  }
  return plan;
}

constexpr double kFrameRate = 25;  // Hz

/// Into the files that were asked for: the trajectory, the picture, the film of what was executed or, where nothing
/// was, of the plan.
Status write_files(const Options& options, const Ground& ground, const motion::Plan& plan,
                   const physics::Recording& executed = {}) {
  if (!study::has_trajectory(plan)) return success();
  const auto& q = plan.trajectory.q;
  if (!options.output.empty()) PRIMO_TRY(write_file(options.output, trajectory_json(plan).dump() + "\n"));
  std::optional<motion::Plan> other;
  if (!options.compare.empty()) {
    PRIMO_ASSIGN(other, read_trajectory(options.compare, ground.robot));
  }
  if (!options.picture.empty()) {
    physics::MotionPictureOptions picture;
    if (other) picture.compare = &other->trajectory.q;
    PRIMO_TRY(physics::render_motion_png(options.picture, ground.robot, ground.scenario, q, picture));
  }
  if (!options.movie.empty()) {
    physics::MovieOptions movie;
    movie.frame_rate = kFrameRate;
    if (other) movie.compare = &other->trajectory.q;
    const auto shown = executed.frames.empty()
                           ? physics::replay(ground.robot, q, plan.trajectory.dt, ground.scenario, 1 / kFrameRate)
                           : executed;
    PRIMO_TRY(physics::render_movie(options.movie, ground.robot, ground.scenario, q, shown, movie));
  }
  return success();
}

std::string sentence_of(const motion::Plan& plan) {
  return "plan: " + config::enum_name(plan.status) + ", " + std::to_string(plan.iterations + plan.rejected) +
         " iterations, cost " + std::to_string(plan.cost_final) + ": " + plan.reason;
}

std::string sentence_of(const physics::Verdict& verdict) {
  std::string text = std::string("verdict: ") + (verdict.success ? "success" : "no success") + ", " +
                     config::enum_name(verdict.outcome) + ": " + verdict.reason;
  for (const auto& criterion : verdict.criteria) {
    text += "\n  " + criterion.name + " " + std::to_string(criterion.value) +
            (criterion.met ? "" : "  not met, margin " + std::to_string(criterion.margin));
  }
  for (const auto& row : verdict.survivals) {
    text += "\n  shaken " + std::to_string(row.amplitude) + " times as hard: held " + std::to_string(row.held) + "/" +
            std::to_string(row.seeds);
  }
  for (const auto& contact : verdict.contacts) {
    text += "\n  " + contact.first + " touches " + contact.second + " from " + std::to_string(contact.begin) + " to " +
            std::to_string(contact.end) + " s, at most " + std::to_string(contact.peak_force) + " N";
  }
  text += "\n  after:";
  for (const auto& literal : verdict.after) text += " " + literal.text();
  return text;
}

/// A plan that is none is a failure of the run.
Status check_plan(const motion::Plan& plan) {
  if (study::has_trajectory(plan)) return success();
  return Error{Code::failed, "no plan: " + plan.reason};
}

nlohmann::ordered_json plan_json(const Ground& ground, const Planned& planned) {
  const auto measures = motion::measure(ground.robot, study::plan_request(planned.rollout), planned.plan);
  return to_json(planned.plan, measures, planned.milliseconds);
}

Status plan(const Options& options) {
  PRIMO_ASSIGN(Ground ground, prepare(options));
  ground.scenario.camera_seed = options.seed;
  PRIMO_ASSIGN(const auto planned, plan_in(options, ground));
  print(options, plan_json(ground, planned), sentence_of(planned.plan));
  PRIMO_TRY(write_files(options, ground, planned.plan));
  return check_plan(planned.plan);
}

Result<physics::Verdict> verdict_of(const Ground& ground, const physics::JudgeRequest& request, double& milliseconds,
                                    physics::Recording& recording) {
  const physics::Judge judge(ground.robot);
  recording.interval = 1 / kFrameRate;
  const auto begin = std::chrono::steady_clock::now();
  auto verdict = judge.evaluate(request, &recording);
  milliseconds = milliseconds_since(begin);
  return verdict;
}

Status judge(const Options& options) {
  PRIMO_ASSIGN(const Ground ground, prepare(options));
  PRIMO_ASSIGN(const auto plan, read_trajectory(options.trajectory, ground.robot));
  study::Rollout rollout;
  rollout.scenario = ground.scenario;
  rollout.judge_seed = options.seed;
  rollout.mode = mode_of(options);
  double milliseconds = 0;
  rollout.judge.survival_seeds = options.survival;
  physics::Recording recording;
  const auto verdict = verdict_of(ground, study::judge_request(rollout, plan), milliseconds, recording);
  if (!verdict.ok()) return verdict.error();
  print(options, to_json(*verdict, milliseconds), sentence_of(*verdict));
  return write_files(options, ground, plan, recording);
}

Status rollout(const Options& options) {
  PRIMO_ASSIGN(const Ground ground, prepare(options));
  PRIMO_ASSIGN(const auto planned, plan_in(options, ground));
  PRIMO_TRY(check_plan(planned.plan));
  double milliseconds = 0;
  physics::Recording recording;
  PRIMO_ASSIGN(const auto verdict,
               verdict_of(ground, study::judge_request(planned.rollout, planned.plan), milliseconds, recording));
  print(options, {{"plan", plan_json(ground, planned)}, {"verdict", to_json(verdict, milliseconds)}},
        sentence_of(planned.plan) + "\n" + sentence_of(verdict));
  return write_files(options, ground, planned.plan, recording);
}

void add_judging(CLI::App& verb, Options& options) {
  verb.add_option("--mode", options.mode, "judge the final pose, or execute the whole motion in physics")
      ->check(CLI::IsMember({"final_pose", "execute"}))
      ->capture_default_str();
  verb.add_option("--survival", options.survival,
                  "also shake a held final pose this often at each of several amplitudes")
      ->check(CLI::Range(0, 1000));
}

void add_planning(CLI::App& verb, Options& options) {
  const auto choice = [&](const std::string& flag, std::string& value, const auto& table) {
    std::string help = "instead of the primitive's:";
    std::vector<std::string> names;
    for (const auto& entry : table) {
      names.push_back(entry.name);
      help += "\n  " + entry.name + ": " + entry.help;
    }
    verb.add_option(flag, value, help)->check(CLI::IsMember(names).description(""))->type_name("NAME");
  };
  verb.add_option("--primitive", options.primitive,
                  "primitive file (default: the hand-tuned one of the scenario's action)");
  choice("--solver", options.solver, motion::planners());
  choice("--start", options.start, motion::starts());
  verb.add_option("--max-iterations", options.max_iterations, "instead of the primitive's")
      ->check(CLI::Range(1, 10000));
}

void add_common(CLI::App& verb, Options& options, const std::string& seeds) {
  verb.add_option("scenario,--scenario", options.scenario, "scenario file")->required();
  verb.add_option("--robot", options.robot, "robot file (default: the Schunk arm)");
  verb.add_option("--seed", options.seed, seeds)->capture_default_str();
  verb.add_option("--png", options.picture, "draw the motion into this file");
  verb.add_option("--mp4", options.movie, "film the motion into this file; with --mode execute what happened");
  verb.add_option("--compare", options.compare, "trajectory file whose path is drawn dashed beside the motion's");
  verb.add_flag("--json", options.json, "print one JSON object");
}

}  // namespace

void add_plan(CLI::App& app, int& exit) {
  const auto options = std::make_shared<Options>();
  auto* verb = app.add_subcommand("plan", "plans a primitive in a scenario, in this process");
  add_common(*verb, *options, "of the depth camera's noise");
  add_planning(*verb, *options);
  verb->add_option("-o,--out", options->output, "write the trajectory and its gains to this file, as JSON");
  verb->callback([options, &exit] { exit = report(plan(*options)); });
}

void add_judge(CLI::App& app, int& exit) {
  const auto options = std::make_shared<Options>();
  auto* verb = app.add_subcommand("judge", "judges a trajectory that primo plan --out wrote, in this process");
  add_common(*verb, *options, "of the jiggle");
  verb->add_option("trajectory,--trajectory", options->trajectory, "trajectory file")->required();
  add_judging(*verb, *options);
  verb->callback([options, &exit] { exit = report(judge(*options)); });
}

void add_rollout(CLI::App& app, int& exit) {
  const auto options = std::make_shared<Options>();
  auto* verb = app.add_subcommand("rollout", "sees a scenario, plans and judges, in this process");
  add_common(*verb, *options, "of the jiggle");
  add_planning(*verb, *options);
  verb->add_option("-o,--out", options->output, "write the trajectory and its gains to this file, as JSON");
  add_judging(*verb, *options);
  verb->callback([options, &exit] { exit = report(rollout(*options)); });
}

}  // namespace primo::tool
