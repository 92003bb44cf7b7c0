// primo plan, judge, rollout: one scenario in this process: see it, plan in what is seen, judge in what is true.
#include "study/rollout.h"

#include <iostream>
#include <memory>

#include "core/files.h"
#include "motion/planner.h"
#include "physics/judge.h"
#include "primo/layout.h"
#include "primo/trajectory_json.h"
#include "primo/verbs.h"
#include "scene/reach.h"
#include "study/local_workers.h"

namespace primo::tool {
namespace {

struct Options {
  std::string scenario, robot, primitive, plan, output, mode = "final_pose";
  std::uint64_t seed = 1;
  bool json = false;
};

/// What all three verbs begin with. The scenario has its robot_start filled in.
struct Ground {
  robot::Robot robot;
  scene::Scenario scenario;
};

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

Result<motion::Primitive> primitive_of(const Options& options) {
  if (!options.primitive.empty()) return motion::read_primitive(options.primitive);
  PRIMO_ASSIGN(const Layout layout, find_layout());
  return motion::read_primitive(layout.root / "configs" / "primitives" / "grasp_hand_tuned.yaml");
}

physics::Mode mode_of(const Options& options) {
  return options.mode == "execute" ? physics::Mode::execute : physics::Mode::final_pose;
}

Result<study::Rollout> rollout_of(const Options& options, const Ground& ground) {
  study::Rollout rollout;
  rollout.scenario = ground.scenario;
  PRIMO_ASSIGN(rollout.primitive, primitive_of(options));
  PRIMO_ASSIGN(rollout.estimate, study::observe_scenario(ground.scenario));
  rollout.judge_seed = options.seed;
  rollout.mode = mode_of(options);
  return rollout;
}

/// Into the file, where one was asked for; JSON or the sentence to the terminal.
Status put(const Options& options, const nlohmann::ordered_json& json, const std::string& sentence) {
  if (!options.output.empty()) PRIMO_TRY(write_file(options.output, json.dump() + "\n"));
  std::cout << (options.json ? json.dump() : sentence) << "\n";
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
  text += "\n  after:";
  for (const auto& literal : verdict.after) text += " " + literal.text();
  return text;
}

/// A plan that is none is a failure of the run.
Status check_plan(const motion::Plan& plan) {
  if (study::has_trajectory(plan)) return success();
  return Error{Code::failed, "no plan: " + plan.reason};
}

Status plan(const Options& options) {
  PRIMO_ASSIGN(const Ground ground, prepare(options));
  PRIMO_ASSIGN(const auto rollout, rollout_of(options, ground));
  const auto plan = motion::plan(ground.robot, study::plan_request(rollout));
  PRIMO_TRY(put(options, to_json(plan), sentence_of(plan)));
  return check_plan(plan);
}

Status judge(const Options& options) {
  PRIMO_ASSIGN(Ground ground, prepare(options));
  PRIMO_ASSIGN(const std::string text, read_file(options.plan));
  const auto plan = plan_from_json(text);
  if (!plan.ok()) return plan.error().at(options.plan);
  if (plan->trajectory.joints != ground.robot.joint_names()) {
    return Error{Code::data, options.plan + ": 'trajectory.joints' are not the joints of " + ground.robot.name() +
                                 " in its robot file's order"};
  }
  study::Rollout rollout;
  rollout.scenario = ground.scenario;
  rollout.judge_seed = options.seed;
  rollout.mode = mode_of(options);
  const auto verdict = physics::Judge(std::move(ground.robot)).evaluate(study::judge_request(rollout, *plan));
  if (!verdict.ok()) return verdict.error();
  return put(options, to_json(*verdict), sentence_of(*verdict));
}

Status rollout(const Options& options) {
  PRIMO_ASSIGN(Ground ground, prepare(options));
  PRIMO_ASSIGN(const auto rollout, rollout_of(options, ground));
  const auto plan = motion::plan(ground.robot, study::plan_request(rollout));
  PRIMO_TRY(check_plan(plan));
  PRIMO_ASSIGN(const auto verdict,
               physics::Judge(std::move(ground.robot)).evaluate(study::judge_request(rollout, plan)));
  return put(options, {{"plan", to_json(plan)}, {"verdict", to_json(verdict)}},
             sentence_of(plan) + "\n" + sentence_of(verdict));
}

void add_judging(CLI::App& verb, Options& options) {
  verb.add_option("--seed", options.seed, "of the jiggle")->capture_default_str();
  verb.add_option("--mode", options.mode, "judge the final pose, or execute the whole motion in physics")
      ->check(CLI::IsMember({"final_pose", "execute"}))
      ->capture_default_str();
}

void add_common(CLI::App& verb, Options& options) {
  verb.add_option("scenario", options.scenario, "scenario file")->required();
  verb.add_option("--robot", options.robot, "robot file (default: the Schunk arm)");
  verb.add_option("-o,--output", options.output, "write JSON to this file");
  verb.add_flag("--json", options.json, "print JSON");
}

}  // namespace

void add_plan(CLI::App& app, int& exit) {
  const auto options = std::make_shared<Options>();
  auto* verb = app.add_subcommand("plan", "plans a primitive in a scenario, in this process");
  add_common(*verb, *options);
  verb->add_option("--primitive", options->primitive, "primitive file (default: the hand-tuned grasp)");
  verb->callback([options, &exit] { exit = report(plan(*options)); });
}

void add_judge(CLI::App& app, int& exit) {
  const auto options = std::make_shared<Options>();
  auto* verb = app.add_subcommand("judge", "judges a plan that primo plan -o wrote, in this process");
  add_common(*verb, *options);
  verb->add_option("plan", options->plan, "plan as JSON")->required();
  add_judging(*verb, *options);
  verb->callback([options, &exit] { exit = report(judge(*options)); });
}

void add_rollout(CLI::App& app, int& exit) {
  const auto options = std::make_shared<Options>();
  auto* verb = app.add_subcommand("rollout", "plans and judges, in this process");
  add_common(*verb, *options);
  verb->add_option("--primitive", options->primitive, "primitive file (default: the hand-tuned grasp)");
  add_judging(*verb, *options);
  verb->callback([options, &exit] { exit = report(rollout(*options)); });
}

}  // namespace primo::tool
