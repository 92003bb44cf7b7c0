// How far verdicts can be trusted: whether plans that the strict final-pose verdict accepts succeed when executed in
// full physics, whether verdicts depend on the time step, and whether good grasps are told from displaced ones.
//   bench_agreement [--action grasp|place] [--plans N] [--seed N] [--verdicts N] [--survival N] [--disagreements
//   FOLDER]
// Which scenes and primitives: agreement_plans.h. Rates come with counts and Wilson's 95 % interval.
#include <CLI/CLI.hpp>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>
#include <string>

#include "bench/agreement_plans.h"
#include "bench/measure.h"
#include "core/files.h"
#include "core/random.h"
#include "primo/trajectory_json.h"
#include "unit/physics/grasp_fixture.h"

namespace {

using namespace primo;
using bench::Planned;
using Json = nlohmann::ordered_json;

struct Options {
  int plans = 500, verdicts = 500, survival = 200, skip = 0;
  std::uint64_t seed = 4242;
  std::string action = "grasp", disagreements;
};

physics::Verdict judged(const physics::Judge& judge, const Planned& planned, physics::Mode mode, double timestep) {
  auto request = study::judge_request(planned.rollout, planned.plan);
  request.mode = mode;
  request.settings.timestep = timestep;
  auto verdict = judge.evaluate(request);
  PRIMO_CHECK(verdict.ok(), verdict.error().message);
  return std::move(*verdict);
}

/// What the rows of the report need.
struct Agreement {
  std::map<std::string, Rate> executed;  ///< of accepted plans, by primitive
  Rate accepted;                         ///< of plans
  Rate changed_final_pose, changed_execution;
  Json disagreements = Json::array();
  int scenes = 0, judged = 0;
};

void keep(const Options& options, const Planned& planned, std::uint64_t index) {
  if (options.disagreements.empty()) return;
  const auto base = std::filesystem::path(options.disagreements) / std::to_string(index);
  const auto a = scene::write_scenario(base.string() + ".yaml", planned.rollout.scenario);
  const auto b = write_file(base.string() + ".json", tool::trajectory_json(planned.plan).dump());
  if (!a.ok() || !b.ok()) std::fprintf(stderr, "bench_agreement: cannot write to %s\n", options.disagreements.c_str());
}

void execute_accepted(const Options& options, const physics::Judge& judge, const Planned& planned, std::uint64_t index,
                      Agreement& found) {
  const auto executed = judged(judge, planned, physics::Mode::execute, 0.002);
  const bool done = executed.final_pose_success;
  for (const auto& key : {planned.rollout.primitive.name, std::string("all")}) found.executed[key].add(done);
  if (done) return;
  found.disagreements.push_back({{"scene", index},
                                 {"scenario", planned.rollout.scenario.name},
                                 {"primitive", planned.rollout.primitive.name},
                                 {"outcome", config::enum_name(executed.outcome)},
                                 {"reason", executed.reason},
                                 {"clearance_m", executed.clearance},
                                 {"target_clearance_m", executed.target_clearance}});
  keep(options, planned, index);
}

Agreement compare(const Options& options, const physics::Judge& judge) {
  const auto plans = bench::plans(judge.robot(), options.seed, options.action == "place");
  Agreement found;
  const int most = 20 * std::max(options.plans, options.verdicts);
  for (int index = options.skip; index < most; ++index) {
    const bool enough = found.executed["all"].trials >= options.plans;
    if (enough && found.judged >= options.verdicts) break;
    ++found.scenes;
    const auto planned = plans->at(static_cast<std::uint64_t>(index));
    if (!planned) continue;
    const auto verdict = judged(judge, *planned, physics::Mode::final_pose, 0.002);
    if (found.judged++ < options.verdicts) {
      found.changed_final_pose.add(judged(judge, *planned, physics::Mode::final_pose, 0.001).success !=
                                   verdict.success);
      found.changed_execution.add(judged(judge, *planned, physics::Mode::execute, 0.001).success !=
                                  judged(judge, *planned, physics::Mode::execute, 0.002).success);
    }
    found.accepted.add(verdict.success);
    if (verdict.success && !enough)
      execute_accepted(options, judge, *planned, static_cast<std::uint64_t>(index), found);
    if (found.judged % 50 == 0) {
      std::fprintf(stderr, "%d scenes, executed %s, dt %s, %s\n", found.scenes, found.executed["all"].text().c_str(),
                   found.changed_final_pose.text().c_str(), found.changed_execution.text().c_str());
    }
  }
  return found;
}

/// How often a hand-made grasp with this offset in the grasp frame's axes is held: one jiggle for each trial.
Json survival(const physics::Judge& judge, const Eigen::Vector3d& offset, int trials) {
  Rate rate;
  const auto scenario = physics::testing::one_cylinder();
  const auto grasp = physics::testing::hand_made_grasp(judge.robot(), scenario, offset);
  if (!grasp) return {{"error", "the arm does not reach this grasp"}};
  for (int k = 0; k < trials; ++k) {
    const auto verdict = judge.evaluate(physics::testing::request_for(scenario, *grasp, static_cast<std::uint64_t>(k)));
    PRIMO_CHECK(verdict.ok(), verdict.error().message);
    rate.add(verdict->final_pose_success);
  }
  return bench::json_of(rate);
}

/// The same with an offset of this length in a direction of its own for each trial: uniform over the half of the sphere
/// where the palm comes nearer to the object (sign 1), which makes an enveloping grasp of one by the tips, or the other
/// half (−1).
Json displaced_anywhere(const physics::Judge& judge, double length, double sign, int trials, std::uint64_t seed) {
  const auto scenario = physics::testing::one_cylinder();
  Rate strict, final_pose;
  for (std::uint64_t k = 0; final_pose.trials < trials && k < 4 * static_cast<std::uint64_t>(trials); ++k) {
    Random random(seed, "direction", {k});
    Eigen::Vector3d direction = Eigen::Vector3d(random.normal(), random.normal(), random.normal()).normalized();
    direction.z() = sign * std::abs(direction.z());
    const auto grasp = physics::testing::hand_made_grasp(judge.robot(), scenario, length * direction);
    if (!grasp) continue;  // out of the arm's reach
    const auto verdict = judge.evaluate(physics::testing::request_for(scenario, *grasp, k));
    PRIMO_CHECK(verdict.ok(), verdict.error().message);
    strict.add(verdict->success);
    final_pose.add(verdict->final_pose_success);
  }
  return {{"success", bench::json_of(strict)}, {"final_pose_success", bench::json_of(final_pose)}};
}

}  // namespace

int main(int argc, char** argv) {
  Options options;
  CLI::App app{"agreement of the judge's two modes"};
  app.add_option("--action", options.action, "grasp or place")->check(CLI::IsMember({"grasp", "place"}));
  app.add_option("--plans", options.plans, "accepted plans to execute")->check(CLI::Range(0, 100000));
  app.add_option("--verdicts", options.verdicts, "verdicts to take again at half the time step")
      ->check(CLI::Range(0, 100000));
  app.add_option("--survival", options.survival, "jiggles a grasp")->check(CLI::Range(0, 100000));
  app.add_option("--seed", options.seed, "of the scenes");
  app.add_option("--skip", options.skip, "scenes to leave out at the beginning")->check(CLI::Range(0, 1000000));
  app.add_option("--disagreements", options.disagreements, "folder for scenarios and trajectories");
  CLI11_PARSE(app, argc, argv);

  const physics::Judge judge(physics::testing::load_robot());
  const Agreement found = compare(options, judge);
  Json out = {{"scenes", found.scenes}, {"plans", found.judged}, {"accepted", bench::json_of(found.accepted)}};
  for (const auto& [name, rate] : found.executed) out["succeed_when_executed"][name] = bench::json_of(rate);
  out["disagreements"] = found.disagreements;
  out["changed_by_half_the_time_step"] = {{"final_pose", bench::json_of(found.changed_final_pose)},
                                          {"execute", bench::json_of(found.changed_execution)}};
  const std::map<std::string, Eigen::Vector3d> offsets = {{"centred", {0, 0, 0}},
                                                          {"along_the_opposition", {0.05, 0, 0}},
                                                          {"along_the_object", {0, 0.05, 0}},
                                                          {"short_of_the_object", {0, 0, -0.05}}};
  for (const auto& [name, offset] : offsets) {
    if (options.action == "grasp" && options.survival > 0)
      out["held"][name] = survival(judge, offset, options.survival);
  }
  if (options.action == "grasp" && options.survival > 0) {
    out["held"]["anywhere_but_deeper"] = displaced_anywhere(judge, 0.05, -1, options.survival, options.seed);
    out["held"]["anywhere_deeper"] = displaced_anywhere(judge, 0.05, 1, options.survival, options.seed);
  }
  std::puts(out.dump(2).c_str());
}
