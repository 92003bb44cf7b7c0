// primo config: every key of a kind of file, and a file with all its defaults written out.
#include "config/config.h"

#include <functional>
#include <iostream>
#include <memory>

#include "motion/primitive.h"
#include "primo/verbs.h"
#include "robot/robot.h"
#include "scene/scenario.h"
#include "study/study.h"

namespace primo::tool {
namespace {

/// A kind of file: what its fields are, and the effective content of one.
struct Kind {
  std::string name;
  std::function<std::string()> describe;
  std::function<Result<std::string>(const std::string& path)> dump;
};

template <class T>
Kind plain(const std::string& name) {
  return {name, [] { return config::describe<T>(); },
          [](const std::string& path) -> Result<std::string> {
            PRIMO_ASSIGN(const T value, config::read<T>(path));
            return config::dump(value);
          }};
}

std::vector<Kind> kinds() {
  return {plain<robot::RobotFile>("robot"),
          {"scenario", [] { return config::describe<scene::Scenario>(); },
           [](const std::string& path) -> Result<std::string> {
             PRIMO_ASSIGN(const auto scenario, scene::read_scenario(path));
             return config::dump(scenario);
           }},
          plain<motion::Primitive>("primitive"),
          {"study", study::describe_study_file, [](const std::string& path) -> Result<std::string> {
             PRIMO_ASSIGN(const auto study, study::load_study(path));
             return config::dump(study);
           }}};
}

struct Options {
  std::string kind, file;
};

const Kind& kind_of(const std::vector<Kind>& all, const std::string& name) {
  for (const auto& kind : all) {
    if (kind.name == name) return kind;
  }
  return all.front();  // not reached: the command line lets only names of the table through
}

Status dump(const Options& options) {
  const auto all = kinds();
  PRIMO_ASSIGN(const std::string text, kind_of(all, options.kind).dump(options.file));
  std::cout << text;
  return success();
}

}  // namespace

void add_config(CLI::App& app, int& exit) {
  const auto options = std::make_shared<Options>();
  std::vector<std::string> names;
  for (const auto& kind : kinds()) names.push_back(kind.name);
  auto* verb = app.add_subcommand("config", "the keys of configuration files");
  verb->require_subcommand(1);

  auto* dump_verb =
      verb->add_subcommand("dump", "prints a file with every default written out, or says what is wrong in it");
  dump_verb->add_option("kind", options->kind, "what the file is")->required()->check(CLI::IsMember(names));
  dump_verb->add_option("file", options->file, "the file")->required();
  dump_verb->callback([options, &exit] { exit = report(dump(*options)); });

  auto* keys_verb = verb->add_subcommand("keys", "lists every key with its default, unit, bounds and meaning");
  keys_verb->add_option("kind", options->kind, "of file")->required()->check(CLI::IsMember(names));
  keys_verb->callback([options] {
    const auto all = kinds();
    std::cout << kind_of(all, options->kind).describe();
  });
}

}  // namespace primo::tool
