// How a primitive fares in displaced scenes when its motions are executed in full physics, and why it fails; and the
// robust optimization that such primitives come from, in this process.
//   bench_robust --training FILE … --primitive FILE [--levels 0,0.015,0.03,0.05] [--count N] [--seed N]
//   bench_robust --training FILE … --primitive FILE --optimize SETTINGS.yaml --out FILE [--evaluations N] [--drawn N]
// Development scenes only: displaced training scenes of seeds that no study file uses. Rates come with counts and
// Wilson's 95 % interval.
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <cstdio>
#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>
#include <string>

#include "bench/measure.h"
#include "core/files.h"
#include "core/random.h"
#include "study/generalization.h"
#include "study/local_workers.h"
#include "study/loop.h"
#include "study/pool.h"

namespace {

using namespace primo;
using Json = nlohmann::ordered_json;

struct Options {
  std::vector<std::string> training;
  std::string primitive, optimize, out, goal = "inhand,X";
  std::vector<double> levels = {0, 0.015, 0.03, 0.05};
  int count = 100, threads = 1, evaluations = 500, population = 18, drawn = 0, pool = 240, choice = 60;
  double displacement = 0.05, sigma = 0.3;
  std::uint64_t seed = 770001;
  std::string algorithm = "cma", failures, outcome;
  bool final_pose = true;
};

template <class T>
T must(Result<T> result) {
  if (!result.ok()) {
    std::fprintf(stderr, "bench_robust: %s\n", result.error().message.c_str());
    std::exit(1);
  }
  return std::move(*result);
}

void must_hold(const Status& status) {
  if (status.ok()) return;
  std::fprintf(stderr, "bench_robust: %s\n", status.error().message.c_str());
  std::exit(1);
}

std::vector<scene::Scenario> read_training(const Options& options, const robot::Robot& robot) {
  std::vector<scene::Scenario> training;
  for (const auto& file : options.training) {
    training.push_back(must(scene::read_scenario(file)));
    auto& start = training.back().robot_start;
    if (start.empty()) start.assign(robot.home().begin(), robot.home().end());
  }
  return training;
}

bool is_object(const scene::Scenario& scenario, const std::string& name) { return scenario.object(name) != nullptr; }

/// One word for why an executed motion failed; empty where it did not.
std::string cause(const study::Rollout& rollout, const study::RolloutResult& result) {
  const auto& v = result.verdict;
  if (v.final_pose_success) return {};
  if (v.outcome == physics::Outcome::bad_plan) return "plan failed";
  const auto& scenario = rollout.scenario;
  const std::string& target = scenario.action[1];
  const double end = rollout.primitive.duration, closed = end + rollout.judge.close_seconds + 0.1;
  const auto of_robot = [&](const std::string& name) {
    return name != scenario.table.name && !is_object(scenario, name);
  };
  double touched = closed;
  for (const auto& contact :
       v.contacts) {  // in the order of their beginnings; the robot's links are first, the table before objects
    if (!of_robot(contact.first)) continue;
    if (contact.second == target) touched = std::min(touched, contact.begin);
    if (contact.second == target || (contact.second != scenario.table.name && !is_object(scenario, contact.second)))
      continue;
    if (contact.begin >= closed || contact.peak_force < 0.5) continue;
    const bool support = scenario.action.size() > 2 && contact.second == scenario.action[2];
    if (support) return "hit support";
    if (contact.begin > touched) continue;  // the object was lost before
    return contact.begin < end ? "collision on the way" : "collision while closing";
  }
  const bool grasp = scenario.action.size() == 2;
  const bool upright = v.after.contains({"upright", {target}});
  const bool late = touched > 0.8 * end;
  if (grasp && touched < end && !upright && v.outcome != physics::Outcome::contact_lost)
    return late ? "knocked over late" : "knocked over on the way";
  if (v.position_error > 0.03) return "out of reach";
  return config::enum_name(v.outcome);
}

struct Level {
  Rate executed, strict, final_pose, strict_executed;
  std::map<std::string, int> causes, outcomes, strict_fails;
  std::vector<double> target_error, obstacle_error, position_error, clearance;
};

void measure_estimate(const study::Rollout& rollout, Level& level) {
  for (const auto& object : rollout.scenario.objects) {
    const auto* seen = rollout.estimate.object(object.name);
    if (!seen) {
      ++level.causes["(unseen " + object.name + ")"];
      continue;
    }
    const double error = (seen->X_WO.translation() - object.position).norm();
    (object.name == rollout.scenario.action[1] ? level.target_error : level.obstacle_error).push_back(error);
  }
}

Json json_of(const Level& level) {
  const auto q = [](const std::vector<double>& values) {
    return Json{bench::quantile(values, 0.5), bench::quantile(values, 0.95), bench::quantile(values, 1)};
  };
  return {{"executed", level.executed.text()},
          {"strict", level.strict.text()},
          {"final_pose", level.final_pose.text()},
          {"executed_of_strict", level.strict_executed.text()},
          {"causes", level.causes},
          {"outcomes", level.outcomes},
          {"strict_fails", level.strict_fails},
          {"estimate_error_of_target_m", q(level.target_error)},
          {"of_obstacles_m", q(level.obstacle_error)},
          {"position_error_m", q(level.position_error)},
          {"clearance_m", q(level.clearance)}};
}

Level measure(const Options& options, study::LocalWorkers& workers, const std::vector<scene::Scenario>& training,
              const motion::Primitive& primitive, double displacement, std::size_t number) {
  Level level;
  const auto drawn = must(study::draw_displaced(workers.robot(), training, displacement, options.seed + number, 0,
                                                static_cast<std::size_t>(options.count), "_development_"));
  const auto& scenes = drawn.scenarios;
  auto estimates = must(workers.observe(scenes));
  std::vector<study::Rollout> rollouts;
  for (std::size_t i = 0; i < scenes.size(); ++i) {
    study::Rollout rollout{
        scenes[i], estimates[i], primitive, Random(options.seed, "bench", {number, i}).bits(), physics::Mode::execute,
        {}};
    measure_estimate(rollout, level);
    rollouts.push_back(rollout);
  }
  std::vector<study::RolloutResult> executed(rollouts.size());
  must_hold(workers.evaluate(rollouts, [&](std::size_t i, study::RolloutResult r) { executed[i] = std::move(r); }));
  std::vector<study::RolloutResult> judged(rollouts.size());
  if (options.final_pose) {
    auto finals = rollouts;
    for (auto& rollout : finals) rollout.mode = physics::Mode::final_pose;
    must_hold(workers.evaluate(finals, [&](std::size_t i, study::RolloutResult r) { judged[i] = std::move(r); }));
  }
  for (std::size_t i = 0; i < rollouts.size(); ++i) {
    const auto& v = executed[i].verdict;
    level.executed.add(v.final_pose_success);
    level.position_error.push_back(v.position_error);
    level.clearance.push_back(v.clearance);
    const auto why = cause(rollouts[i], executed[i]);
    if (!why.empty()) {
      ++level.causes[why];
      ++level.outcomes[std::string(config::enum_name(v.outcome))];
      std::fprintf(stderr, "%g %s: %s | %s | clear %.1f mm target %.1f mm error %.1f mm limit %.3f speed %.2f\n",
                   displacement, scenes[i].name.c_str(), why.c_str(), v.reason.c_str(), 1e3 * v.clearance,
                   1e3 * v.target_clearance, 1e3 * v.position_error, v.limit_margin, v.max_speed);
      for (const auto& c : v.contacts)
        std::fprintf(stderr, "    %s - %s %.2f..%.2f s, %.1f N\n", c.first.c_str(), c.second.c_str(), c.begin, c.end,
                     c.peak_force);
      if (!options.failures.empty()) {
        const auto file =
            std::filesystem::path(options.failures) / (std::to_string(number) + "_" + scenes[i].name + ".yaml");
        must_hold(scene::write_scenario(file, scenes[i]));
      }
    }
    if (!options.final_pose) continue;
    const auto& s = judged[i].verdict;
    level.final_pose.add(s.final_pose_success);
    level.strict.add(s.success);
    if (s.success) level.strict_executed.add(v.final_pose_success);
    if (!s.final_pose_success) ++level.strict_fails[std::string(config::enum_name(s.outcome))];
    for (const auto& c : s.criteria) {
      if (!c.met) ++level.strict_fails[c.name];
    }
  }
  return level;
}

motion::Primitive optimized(const Options& options, study::LocalWorkers& workers,
                            const std::vector<scene::Scenario>& training, const motion::Primitive& primitive) {
  study::OptimizeGoal goal;
  goal.study = "bench";
  const auto directory = std::filesystem::temp_directory_path() / ("primo_robust_" + std::to_string(::getpid()));
  std::filesystem::create_directories(directory);
  goal.directory = directory.string();
  goal.primitive = primitive;
  goal.scenarios =
      must(study::draw_pool(workers.robot(), training, options.pool, options.displacement, options.seed + 100, "pool"));
  auto held_out = must(
      study::draw_pool(workers.robot(), training, options.choice, options.displacement, options.seed + 200, "choice"));
  goal.scenarios.insert(goal.scenarios.end(), held_out.begin(), held_out.end());
  goal.estimates = must(workers.observe(goal.scenarios));
  goal.drawn = options.drawn > 0 ? options.drawn : static_cast<int>(training.size());
  goal.held_out = options.choice;
  symbols::Literal literal{options.goal.substr(0, options.goal.find(',')), {}};
  for (std::size_t at = options.goal.find(','); at != std::string::npos; at = options.goal.find(',', at + 1))
    literal.arguments.push_back(options.goal.substr(at + 1, options.goal.find(',', at + 1) - at - 1));
  goal.desired = {literal};
  goal.optimizer.evaluations = options.evaluations;
  goal.optimizer.population = options.population;
  goal.optimizer.sigma = options.sigma;
  goal.algorithms = {options.algorithm};
  goal.seed = options.seed;
  if (options.optimize != "-") goal.settings = must(read_file(options.optimize));
  const auto result = must(study::optimize_in_directory(goal, workers, [](const study::Progress& p) {
    std::fprintf(stderr, "%s %d/%d mean %.3f best %.3f sigma %.3f\n", p.algorithm.c_str(), p.done, p.total,
                 p.mean_gamma, p.best_gamma, p.sigma);
  }));
  std::fprintf(stderr, "chosen: %s gamma %.3f, %s\n", result.primitive.name.c_str(), result.gamma,
               result.success.text().c_str());
  std::filesystem::remove_all(directory);
  if (!options.out.empty()) must_hold(write_file(options.out, config::dump(result.primitive)));
  return result.primitive;
}

}  // namespace

int main(int argc, char** argv) {
  Options options;
  CLI::App app{"primitives in displaced scenes, executed in full physics"};
  app.add_option("--training", options.training, "scenario files")->required();
  app.add_option("--primitive", options.primitive)->required();
  app.add_option("--optimize", options.optimize, "settings of the optimization (YAML file; -: defaults)");
  app.add_option("--out", options.out, "file for the optimized primitive");
  app.add_option("--goal", options.goal, "predicate and arguments");
  app.add_option("--levels", options.levels, "m")->delimiter(',');
  app.add_option("--count", options.count, "scenes a level");
  app.add_option("--threads", options.threads);
  app.add_option("--evaluations", options.evaluations);
  app.add_option("--population", options.population);
  app.add_option("--drawn", options.drawn, "scenes a generation; 0: as many as training scenes");
  app.add_option("--pool", options.pool);
  app.add_option("--choice", options.choice, "scenes of the choice");
  app.add_option("--displacement", options.displacement, "greatest in the pool, m");
  app.add_option("--sigma", options.sigma);
  app.add_option("--algorithm", options.algorithm);
  app.add_option("--seed", options.seed);
  app.add_option("--failures", options.failures, "folder for the scenes that failed");
  app.add_flag("!--executed-only", options.final_pose, "no final-pose verdicts");
  CLI11_PARSE(app, argc, argv);

  study::LocalOptions local;
  local.threads = options.threads;
  const auto workers = must(study::LocalWorkers::create(
      std::filesystem::path(PRIMO_SOURCE_DIR) / "configs/robots/schunk_lwa3_sdh2.yaml", local));
  const auto training = read_training(options, workers->robot());
  motion::Primitive primitive = must(motion::read_primitive(options.primitive));
  if (!options.optimize.empty()) primitive = optimized(options, *workers, training, primitive);
  Json out = {{"primitive", primitive.name}};
  for (std::size_t l = 0; l < options.levels.size(); ++l) {
    const auto level = measure(options, *workers, training, primitive, options.levels[l], l);
    out["levels"][std::to_string(options.levels[l]).substr(0, 5)] = json_of(level);
  }
  std::puts(out.dump(2).c_str());
}
