// primo rules show|export|plan|diagnose|diff: what can be done with a file of rules.
#include <cstdio>
#include <iostream>
#include <memory>

#include "core/files.h"
#include "primo/rules_io.h"
#include "primo/verbs.h"
#include "rules/analysis.h"
#include "rules/export.h"
#include "rules/plan.h"
#include "symbols/derived.h"
#include "symbols/literal_json.h"

namespace primo::tool {
namespace {

using symbols::Json;
using symbols::literal_to_json;

struct Options {
  std::string rules, other, output, state, goal;
  std::string format = "text", noise = "no-change", method = "uct";
  std::vector<std::string> experiences;
  bool json = false, skip_bad = false;
  int horizon = 10;
  rules::PlanSettings plan;
};

Status show(const Options& options) {
  PRIMO_ASSIGN(const auto rules, read_rules(options.rules));
  std::cout << (options.json ? rules::to_json(rules) + "\n" : rules::to_text(rules));
  return success();
}

Status export_rules(const Options& options) {
  PRIMO_ASSIGN(const auto rules, read_rules(options.rules));
  std::string text;
  if (options.format == "ppddl") {
    using Noise = rules::PpddlOptions::Noise;
    const auto noise = options.noise == "dead-end" ? Noise::dead_end : Noise::no_change;
    PRIMO_ASSIGN(const auto domain, rules::to_ppddl(rules, {.domain = "primo", .noise = noise}));
    text = domain.text;
    if (domain.largest_noise > 0) {
      std::cerr << "primo: PPDDL has no noise: up to " << domain.largest_noise << " of a rule's probability became "
                << (noise == Noise::dead_end ? "a dead end" : "no change") << "\n";
    }
  } else {
    text = options.format == "json"    ? rules::to_json(rules) + "\n"
           : options.format == "latex" ? rules::to_latex(rules)
                                       : rules::to_text(rules);
  }
  if (!options.output.empty()) return write_file(options.output, text);
  std::cout << text;
  return success();
}

/// "on(a,b) and not wet": a conjunction of literals.
Result<std::vector<symbols::Literal>> read_goal(const std::string& text) {
  const auto goal = symbols::definition_from_text("goal := " + text);
  if (!goal.ok())
    return Error{Code::usage, "--goal: " + goal.error().message + "; a goal is such as on(a,b) and not wet"};
  std::vector<symbols::Formula> parts{goal->body};
  if (goal->body.kind == symbols::Formula::Kind::conjunction && !goal->body.negated) parts = goal->body.parts;
  std::vector<symbols::Literal> literals;
  for (const auto& part : parts) {
    if (part.kind != symbols::Formula::Kind::literal) {
      return Error{Code::usage, "--goal: only literals joined by and, no quantifiers"};
    }
    literals.push_back(part.literal);
    literals.back().negated = part.negated;
  }
  return literals;
}

void print(const rules::Plan& plan, const Options& options) {
  if (options.json) {
    Json steps = Json::array();
    for (const auto& step : plan.steps) steps.push_back({{"action", literal_to_json(step.action)}, {"p", step.p}});
    std::cout << symbols::dump({{"method", options.method}, {"success", plan.success}, {"steps", std::move(steps)}})
              << "\n";
    return;
  }
  for (std::size_t i = 0; i < plan.steps.size(); ++i) {
    std::printf("%zu. %s   (%.2f)\n", i + 1, plan.steps[i].action.text().c_str(), plan.steps[i].p);
  }
  std::printf("predicted probability of success within %d actions: %.4f\n", options.horizon, plan.success);
}

Status plan(const Options& options) {
  PRIMO_ASSIGN(const auto rules, read_rules(options.rules));
  PRIMO_ASSIGN(const std::string text, read_file(options.state));
  auto situation = symbols::situation_from_json(text);
  if (!situation.ok()) return situation.error().at(options.state);
  PRIMO_ASSIGN(auto goal, read_goal(options.goal));
  const rules::PlanProblem problem{situation->objects, situation->state, std::move(goal), options.horizon};
  PRIMO_ASSIGN(const auto found, options.method == "uct" ? rules::plan_uct(rules, problem, options.plan)
                                                         : rules::plan_replan(rules, problem, options.plan));
  print(found, options);
  return success();
}

Status diagnose(const Options& options) {
  PRIMO_ASSIGN(const auto rules, read_rules(options.rules));
  std::vector<symbols::Experience> experiences;
  PRIMO_TRY(
      read_all_for(rules, options.experiences, options.skip_bad, [&](symbols::Experience&& e, const std::string&) {
        experiences.push_back(std::move(e));
        return success();
      }));
  const auto diagnosis = rules::diagnose(rules, experiences);
  Json list = Json::array(), defaults = Json::object();
  for (const auto& entry : diagnosis.rules) {
    Json json = {{"action", literal_to_json(rules.rules[entry.rule].action)},
                 {"entropy", entry.entropy},
                 {"noise", entry.noise},
                 {"covered", entry.covered},
                 {"unexplained", entry.unexplained},
                 {"split", nullptr}};
    if (entry.split) json["split"] = {{"literal", literal_to_json(entry.split->literal)}, {"gain", entry.split->gain}};
    list.push_back(std::move(json));
  }
  for (const auto& entry : diagnosis.defaults) {
    defaults[entry.action] = {{"covered", entry.covered}, {"unexplained", entry.unexplained}};
  }
  std::cout << symbols::dump({{"rules", std::move(list)}, {"default", std::move(defaults)}}) << "\n";
  return success();
}

Status diff(const Options& options) {
  PRIMO_ASSIGN(const auto from, read_rules(options.rules));
  PRIMO_ASSIGN(const auto to, read_rules(options.other));
  const auto difference = rules::difference(from, to);
  const auto print = [](const char* mark, const std::vector<rules::Rule>& rules) {
    for (const auto& rule : rules) std::cout << mark << rules::to_text(rule);
  };
  print("- ", difference.removed);
  print("+ ", difference.added);
  print("~ ", difference.changed);
  return success();
}

}  // namespace

void add_rules_use(CLI::App& rules, int& exit) {
  const auto options = std::make_shared<Options>();
  const auto add = [&](const char* name, const char* help, Status (*run)(const Options&)) {
    auto* verb = rules.add_subcommand(name, help);
    verb->add_option("--rules,rules", options->rules, "rules as JSON")->required();
    verb->callback([options, run, &exit] { exit = report(run(*options)); });
    return verb;
  };
  add("show", "prints rules in the paper's notation", show)->add_flag("--json", options->json, "print JSON");

  auto* export_verb = add("export", "writes rules as text, LaTeX, PPDDL or JSON", export_rules);
  export_verb->add_option("--format", options->format, "text, latex, ppddl or json")
      ->check(CLI::IsMember({"text", "latex", "ppddl", "json"}))
      ->capture_default_str();
  export_verb->add_option("--noise", options->noise, "what noise becomes in PPDDL: no-change or dead-end")
      ->check(CLI::IsMember({"no-change", "dead-end"}))
      ->capture_default_str();
  export_verb->add_option("--out", options->output, "write to this file");

  auto* plan_verb = add("plan", "plans with the rules towards a goal", plan);
  plan_verb->add_option("--state", options->state, "JSON with objects and s, as in an experience")->required();
  plan_verb->add_option("--goal", options->goal, "such as: on(a,b) and not wet")->required();
  plan_verb->add_option("--method", options->method, "uct or replan")
      ->check(CLI::IsMember({"uct", "replan"}))
      ->capture_default_str();
  plan_verb->add_option("--horizon", options->horizon, "actions at most")
      ->check(CLI::Range(1, 1000))
      ->capture_default_str();
  plan_verb->add_option("--simulations", options->plan.simulations, "of uct, from the start")
      ->check(CLI::Range(1, 10000000))
      ->capture_default_str();
  plan_verb->add_option("--seed", options->plan.seed, "of uct")->capture_default_str();
  plan_verb->add_flag("--json", options->json, "print JSON");

  auto* diagnose_verb = add("diagnose", "entropy, noise and what is unexplained, as JSON", diagnose);
  diagnose_verb->add_option("--experiences", options->experiences, "files of experiences")->required();
  diagnose_verb->add_flag("--skip-bad", options->skip_bad, "count lines that cannot be used");

  add("diff", "rules added (+), removed (-) and changed (~) from one file to another", diff)
      ->add_option("--to", options->other, "the later rules")
      ->required();
}

}  // namespace primo::tool
