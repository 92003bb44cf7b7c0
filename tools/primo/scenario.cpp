// primo scenario: check scenario files, make displaced and random ones.
#include "scene/scenario.h"

#include <cstdio>
#include <filesystem>
#include <iostream>
#include <memory>

#include "core/files.h"
#include "physics/place_scenes.h"
#include "primo/layout.h"
#include "primo/verbs.h"
#include "scene/generator.h"
#include "scene/reach.h"

namespace primo::tool {
namespace {

namespace fs = std::filesystem;

struct Options {
  std::vector<std::string> files;
  std::string robot, base, output = ".", action = "grasp";
  int count = 1;
  double displacement = 0.02;
  scene::RandomSceneSettings scenes;
  std::uint64_t seed = 1;
};

Result<robot::Robot> load_robot(const std::string& file) {
  if (!file.empty()) return robot::Robot::load(file);
  PRIMO_ASSIGN(const Layout layout, find_layout());
  return robot::Robot::load(layout.root / "configs" / "robots" / "schunk_lwa3_sdh2.yaml");
}

Status check(const Options& options) {
  PRIMO_ASSIGN(const auto robot, load_robot(options.robot));
  for (const auto& file : options.files) {
    PRIMO_ASSIGN(const auto scenario, scene::read_scenario(file));
    if (const auto status = scene::check_robot(scenario, robot); !status.ok()) return status.error().at(file);
    std::cout << file << ": " << scenario.name << ", scene " << scene::scene_id(scenario) << ", "
              << scenario.objects.size() << " objects, good for " << robot.name() << "\n";
  }
  return success();
}

/// Scenario `index`: displaced from the base, or random where there is none.
Result<scene::Scenario> make(const Options& options, const robot::Robot& robot,
                             const std::optional<scene::Scenario>& base, int index, int& rejected) {
  const auto i = static_cast<std::uint64_t>(index);
  if (!base && options.action == "place")
    return physics::random_place_scenario(robot, {.scenes = options.scenes}, options.seed, i);
  if (!base) return scene::random_scenario(options.scenes, options.seed, i);
  PRIMO_ASSIGN(auto displaced, scene::displace(robot, *base, options.displacement, options.seed, i));
  rejected += displaced.rejected();
  return std::move(displaced.scenario);
}

Status generate(const Options& options) {
  PRIMO_ASSIGN(const auto robot, load_robot(options.robot));
  std::optional<scene::Scenario> base;
  if (!options.base.empty()) {
    PRIMO_ASSIGN(base, scene::read_scenario(options.base));
  }
  std::error_code ec;
  fs::create_directories(options.output, ec);
  if (ec) return Error{Code::config, options.output + ": cannot be made: " + ec.message()};
  int rejected = 0;
  for (int i = 0; i < options.count; ++i) {
    PRIMO_ASSIGN(auto scenario, make(options, robot, base, i, rejected));
    PRIMO_TRY(scene::check_robot(scenario, robot));
    char number[16];
    std::snprintf(number, sizeof number, "%04d", i);
    scenario.name = (base                        ? base->name
                     : options.action == "place" ? "place_random"
                                                 : "random") +
                    std::string("_") + number;
    PRIMO_TRY(write_file(fs::path(options.output) / (scenario.name + ".yaml"), config::dump(scenario)));
  }
  std::cout << "primo: " << options.count << " scenarios in " << options.output;
  if (base)
    std::cout << "; " << rejected << " draws rejected because objects touched, fell off the table or lay in the robot";
  std::cout << "\n";
  return success();
}

}  // namespace

void add_scenario(CLI::App& app, int& exit) {
  const auto options = std::make_shared<Options>();
  auto* verb = app.add_subcommand("scenario", "scenario files: check them, make more of them");
  verb->require_subcommand(1);

  auto* check_verb = verb->add_subcommand("check", "says whether scenario files are good for a robot, and why not");
  check_verb->add_option("file", options->files, "scenario files")->required();
  check_verb->add_option("--robot", options->robot, "robot file (default: the Schunk arm)");
  check_verb->callback([options, &exit] { exit = report(check(*options)); });

  auto* generate_verb = verb->add_subcommand("generate", "writes displaced copies of a scenario, or random scenes");
  generate_verb->add_option("--base", options->base, "scenario to displace (default: random scenes)");
  generate_verb
      ->add_option("-d,--displacement", options->displacement, "of each object, uniform on each axis in the plane, m")
      ->check(CLI::Range(0.0, 0.5))
      ->capture_default_str();
  generate_verb->add_option("-n,--count", options->count, "how many")
      ->check(CLI::Range(1, 100000))
      ->capture_default_str();
  generate_verb->add_option("--action", options->action, "of random scenes")
      ->check(CLI::IsMember({"grasp", "place"}))
      ->capture_default_str();
  generate_verb->add_option("--radius", options->scenes.radius, "of the cylinders of random scenes, m")
      ->check(CLI::Range(0.005, 0.1))
      ->capture_default_str();
  generate_verb->add_option("--seed", options->seed, "of the random numbers")->capture_default_str();
  generate_verb->add_option("--robot", options->robot, "robot file (default: the Schunk arm)");
  generate_verb->add_option("-o,--output", options->output, "folder")->capture_default_str();
  generate_verb->callback([options, &exit] { exit = report(generate(*options)); });

  add_scenario_select(*verb, exit);
}

}  // namespace primo::tool
