// primo rules: learn rules from a file of experiences, show a file of rules.
#include <iostream>
#include <memory>
#include <sstream>

#include "config/config.h"
#include "core/files.h"
#include "primo/verbs.h"
#include "rules/learner.h"
#include "rules/rule.h"

namespace primo::tool {
namespace {

struct Options {
  std::vector<std::string> files;
  std::string output;
  bool json = false;
  rules::LearnerSettings learner;
};

Result<std::vector<symbols::Experience>> read_experiences(const std::vector<std::string>& files) {
  std::vector<symbols::Experience> experiences;
  for (const auto& file : files) {
    PRIMO_ASSIGN(const std::string text, read_file(file));
    std::istringstream lines(text);
    std::string line;
    for (int number = 1; std::getline(lines, line); ++number) {
      if (line.find_first_not_of(" \t\r") == std::string::npos) continue;
      auto experience = symbols::experience_from_json(line);
      if (!experience.ok()) return experience.error().at(file + ":" + std::to_string(number));
      experiences.push_back(std::move(experience).value());
    }
  }
  return experiences;
}

Status show(const rules::RuleSet& rules, const Options& options) {
  if (!options.output.empty()) PRIMO_TRY(write_file(options.output, rules::to_json(rules) + "\n"));
  if (options.json) {
    std::cout << rules::to_json(rules) << "\n";
  } else {
    std::cout << rules::to_text(rules);
  }
  return success();
}

Status learn(const Options& options) {
  PRIMO_ASSIGN(const auto experiences, read_experiences(options.files));
  if (experiences.empty())
    return Error{Code::data, options.files.front() + ": holds no experience; expected one JSON object a line"};
  PRIMO_ASSIGN(const auto rules, rules::learn(experiences, options.learner));
  return show(rules, options);
}

Status show_file(const Options& options) {
  PRIMO_ASSIGN(const std::string text, read_file(options.files.front()));
  const auto rules = rules::rules_from_json(text);
  if (!rules.ok()) return rules.error().at(options.files.front());
  return show(*rules, options);
}

}  // namespace

void add_rules(CLI::App& app, int& exit) {
  auto* rules = app.add_subcommand("rules", "NID rules: learn them from experiences, show them");
  rules->require_subcommand(1);
  const auto options = std::make_shared<Options>();

  auto* learn_verb = rules->add_subcommand("learn", "learns rules from files of experiences, one JSON object a line");
  learn_verb->add_option("file", options->files, "files of experiences")->required();
  learn_verb->add_option("--alpha", options->learner.alpha, "penalty of a literal, nats")
      ->check(CLI::Range(0.0, 1e6))
      ->capture_default_str();
  learn_verb->add_option("--p-min", options->learner.p_min, "probability noise gives to a state")
      ->check(CLI::Range(1e-300, 0.1))
      ->capture_default_str();
  learn_verb->add_option("-o,--output", options->output, "write the rules to this file as JSON");
  learn_verb->add_flag("--json", options->json, "print JSON instead of the paper's notation");
  learn_verb->callback([options, &exit] { exit = report(learn(*options)); });

  auto* show_verb = rules->add_subcommand("show", "prints a file of rules in the paper's notation");
  show_verb->add_option("file", options->files, "rules as JSON")->required()->expected(1);
  show_verb->add_flag("--json", options->json, "print JSON");
  show_verb->callback([options, &exit] { exit = report(show_file(*options)); });
}

}  // namespace primo::tool
