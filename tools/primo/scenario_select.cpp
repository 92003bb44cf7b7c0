// primo scenario select: training scenarios that are difficult for one primitive and feasible for another.
#include <cstdio>
#include <filesystem>
#include <iostream>
#include <memory>

#include "core/files.h"
#include "physics/place_scenes.h"
#include "primo/interrupt.h"
#include "primo/layout.h"
#include "primo/verbs.h"
#include "study/local_workers.h"
#include "study/scenario_selection.h"

namespace primo::tool {
namespace {

namespace fs = std::filesystem;

struct Options {
  std::string robot, hand_tuned, reference, output = ".", prefix, action = "grasp";
  study::SelectionSettings settings;
};

std::vector<double> home(const robot::RobotFile& file) {
  std::vector<double> q;
  for (const auto& joint : file.arm) q.push_back(joint.home);
  for (const auto& joint : file.hand) q.push_back(joint.home);
  return q;
}

/// Random scenes of the action.
study::SceneSource source(const Options& options, const robot::Robot& robot) {
  const std::uint64_t seed = options.settings.seed;
  if (options.action == "place")
    return [&robot, seed](std::uint64_t index) { return physics::random_place_scenario(robot, {}, seed, index); };
  return [&robot, seed](std::uint64_t index) -> Result<scene::Scenario> {
    PRIMO_ASSIGN(auto scenario, scene::random_scenario({}, seed, index));
    scenario.robot_start = home(robot.file());
    return scenario;
  };
}

void say(const study::SelectedScenario& tried) {
  std::cout << "scene " << tried.index << ": hand-tuned " << tried.hand_tuned.text();
  if (tried.reference.trials > 0) std::cout << ", reference " << tried.reference.text();
  std::cout << (tried.chosen ? "  chosen\n" : "\n") << std::flush;
}

Status select(const Options& options) {
  PRIMO_ASSIGN(const Layout layout, find_layout());
  const auto robot_file =
      options.robot.empty() ? layout.root / "configs" / "robots" / "schunk_lwa3_sdh2.yaml" : fs::path(options.robot);
  const auto hand_tuned_file = options.hand_tuned.empty()
                                   ? layout.root / "configs" / "primitives" / (options.action + "_hand_tuned.yaml")
                                   : fs::path(options.hand_tuned);
  PRIMO_ASSIGN(const auto hand_tuned, motion::read_primitive(hand_tuned_file));
  PRIMO_ASSIGN(const auto reference, motion::read_primitive(options.reference));
  study::LocalOptions local;
  local.stopping = interrupted;
  PRIMO_ASSIGN(auto workers, study::LocalWorkers::create(robot_file, std::move(local)));
  PRIMO_ASSIGN(const auto tried,
               study::select_difficult(options.settings, workers->robot(), source(options, workers->robot()),
                                       hand_tuned, reference, *workers, say));
  int number = 0;
  for (auto one : tried) {
    if (!one.chosen) continue;
    one.scenario.name = (options.prefix.empty() ? options.action : options.prefix) + "_" + std::to_string(++number);
    PRIMO_TRY(write_file(fs::path(options.output) / (one.scenario.name + ".yaml"), config::dump(one.scenario)));
  }
  std::cout << "primo: " << number << " scenarios of " << tried.size() << " tried, in " << options.output << "\n";
  return success();
}

}  // namespace

void add_scenario_select(CLI::App& scenario, int& exit) {
  const auto options = std::make_shared<Options>();
  auto& settings = options->settings;
  auto* verb = scenario.add_subcommand(
      "select", "random scenes in which the hand-tuned primitive mostly fails and a reference primitive succeeds");
  verb->add_option("--reference", options->reference, "primitive that shows that a scene is feasible")->required();
  verb->add_option("--hand-tuned", options->hand_tuned,
                   "primitive for which it must be difficult (default: the published one of the action)");
  verb->add_option("--robot", options->robot, "robot file (default: the Schunk arm)");
  verb->add_option("-n,--count", settings.count, "how many")->check(CLI::Range(1, 1000))->capture_default_str();
  verb->add_option("--pool", settings.pool, "random scenes to try at most")
      ->check(CLI::Range(1, 100000))
      ->capture_default_str();
  verb->add_option("--seed", settings.seed, "of the random scenes")->capture_default_str();
  verb->add_option("--displaced", settings.displaced, "displaced copies of each")
      ->check(CLI::Range(0, 1000))
      ->capture_default_str();
  verb->add_option("-d,--displacement", settings.displacement, "of the copies, m")
      ->check(CLI::Range(0.0, 0.5))
      ->capture_default_str();
  verb->add_option("--prefix", options->prefix, "of the scenarios' names (default: the action)");
  verb->add_option("--action", options->action, "what is tried in the scenes")
      ->check(CLI::IsMember({"grasp", "place"}))
      ->capture_default_str();
  verb->add_option("-o,--output", options->output, "folder")->check(CLI::ExistingDirectory)->capture_default_str();
  verb->callback([options, &exit] { exit = report(select(*options)); });
}

}  // namespace primo::tool
