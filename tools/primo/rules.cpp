// primo rules learn|predict|score: from experiences to rules, and what rules say of experiences.
#include <algorithm>
#include <cmath>
#include <iostream>
#include <memory>

#include "core/files.h"
#include "primo/rules_io.h"
#include "primo/verbs.h"
#include "rules/invent.h"
#include "rules/score.h"
#include "symbols/literal_json.h"
#include "symbols/signatures.h"

namespace primo::tool {
namespace {

using symbols::Experience;
using symbols::Json;

struct Options {
  std::vector<std::string> experiences, constants;
  std::string rules, output, derived;
  bool json = false, skip_bad = false, invent = false;
  std::uint64_t seed = 0;
  rules::LearnerSettings learner;
};

Json state_json(const symbols::State& state) {
  Json json = Json::array();
  for (const auto& literal : state) json.push_back(symbols::literal_to_json(literal));
  return json;
}

Result<rules::RuleSet> learned(const Options& options, const rules::Background& background) {
  if (options.invent) {
    std::vector<Experience> all;
    PRIMO_TRY(read_all(options.experiences, options.skip_bad, [&](Experience&& experience, const std::string&) {
      all.push_back(std::move(experience));
      return success();
    }));
    return rules::learn_inventing(all, options.learner, background);
  }
  rules::ExperienceStore store(background);
  PRIMO_TRY(
      read_all(options.experiences, options.skip_bad, [&](Experience&& experience, const std::string& where) -> Status {
        PRIMO_TRY(store.add(experience, where));
        return success();
      }));
  if (store.size() == 0) std::cerr << "primo: no experience was read; without any there are no rules\n";
  return rules::learn(store, options.learner);
}

Status learn(const Options& options) {
  rules::Background background{.derived = {}, .constants = options.constants};
  if (!options.derived.empty()) {
    PRIMO_ASSIGN(const std::string text, read_file(options.derived));
    PRIMO_ASSIGN(background.derived, symbols::definitions_from_text(text, options.derived));
  }
  for (const auto& name : options.constants) {
    if (symbols::is_name(name) && !symbols::is_variable(name)) continue;
    return Error{Code::usage, "--constants: \"" + name + "\" cannot name an object"};
  }
  PRIMO_ASSIGN(const auto rules, learned(options, background));
  if (!options.output.empty()) PRIMO_TRY(write_file(options.output, rules::to_json(rules) + "\n"));
  std::cout << (options.json ? rules::to_json(rules) + "\n" : rules::to_text(rules));
  return success();
}

Status predict(const Options& options) {
  PRIMO_ASSIGN(const auto rules, read_rules(options.rules));
  const rules::Predictor predictor(rules);
  return read_all_for(rules, options.experiences, options.skip_bad, [&](Experience&& e, const std::string&) {
    const auto prediction = predictor.predict(e.objects, e.before, e.action);
    Json successors = Json::array();
    for (const auto& [state, p] : prediction.successors) successors.push_back(Json::array({state_json(state), p}));
    std::cout << symbols::dump({{"successors", std::move(successors)}, {"noise", prediction.noise}}) << "\n";
    return success();
  });
}

Status score(const Options& options) {
  PRIMO_ASSIGN(const auto rules, read_rules(options.rules));
  const rules::Predictor predictor(rules);
  double log_likelihood = 0;
  std::int64_t impossible = 0;
  PRIMO_TRY(read_all_for(rules, options.experiences, options.skip_bad, [&](Experience&& e, const std::string&) {
    const double p = rules::likelihood(predictor, e, options.learner.p_min);
    impossible += !(p > 0);
    log_likelihood += std::log(p);
    return success();
  }));
  if (impossible > 0) {
    std::cerr << "primo: the rules give probability 0 to " << impossible
              << " of the experiences: the log-likelihood is minus infinity (null)\n";
  }
  const auto penalty = rules::penalty(rules);
  // JSON has no infinity.
  const auto number = [&](double value) { return impossible > 0 ? Json(nullptr) : Json(value); };
  std::cout << symbols::dump({{"log_likelihood", number(log_likelihood)},
                              {"penalty", penalty},
                              {"score", number(log_likelihood - options.learner.alpha * static_cast<double>(penalty))}})
            << "\n";
  return success();
}

void add_experiences(CLI::App& verb, Options& options) {
  verb.add_option("--experiences", options.experiences, "files of experiences, one JSON object a line")->required();
  verb.add_flag("--skip-bad", options.skip_bad, "count lines that cannot be used instead of stopping at the first");
}

void add_score_options(CLI::App& verb, Options& options) {
  verb.add_option("--alpha", options.learner.alpha, "penalty of a literal, nats")
      ->check(CLI::Range(0.0, 1e6))
      ->capture_default_str();
  verb.add_option("--p-min", options.learner.p_min, "probability noise gives to a state")
      ->check(CLI::Range(1e-300, 0.1))
      ->capture_default_str();
}

void add_learn(CLI::App& rules, int& exit) {
  const auto options = std::make_shared<Options>();
  auto* verb = rules.add_subcommand("learn", "learns rules from experiences and prints them");
  add_experiences(*verb, *options);
  add_score_options(*verb, *options);
  verb->add_option("--out", options->output, "write the rules to this file as JSON");
  verb->add_option("--seed", options->seed, "accepted; the search draws nothing at random, so all seeds give the same");
  verb->add_option("--derived", options->derived,
                   "definitions of derived predicates, such as clear(X) := not exists Y: on(Y,X)");
  verb->add_option("--constants", options->constants,
                   "objects that are the same in all experiences and that rules may name")
      ->delimiter(',');
  verb->add_flag("--invent", options->invent, "invent derived predicates where they make the rules score better");
  verb->add_option("--caution", options->learner.caution, "what each rule must earn beyond its literals, nats")
      ->check(CLI::Range(0.0, 1e6))
      ->capture_default_str();
  verb->add_option("--requirement", options->learner.requirement,
                   "what a context literal earns that outcomes make false, times their probability, nats")
      ->check(CLI::Range(0.0, 1e6))
      ->capture_default_str();
  verb->add_option("--negation", options->learner.negation,
                   "what a negated context literal costs that no split of rules made, nats")
      ->check(CLI::Range(0.0, 1e6))
      ->capture_default_str();
  verb->add_option("--guess", options->learner.guess,
                   "what a context literal of one object or none costs that some action changes and this one does not "
                   "undo, nats")
      ->check(CLI::Range(0.0, 1e6))
      ->capture_default_str();
  verb->add_option("--term", options->learner.term, "what each term of a context literal costs, nats")
      ->check(CLI::Range(0.0, 1e6))
      ->capture_default_str();
  verb->add_option("--max-references", options->learner.max_references, "deictic variables a rule")
      ->check(CLI::Range(0, 6))
      ->capture_default_str();
  verb->add_option("--look-ahead", options->learner.look_ahead, "worse neighbours of a local optimum to go on from")
      ->check(CLI::Range(0, 10000))
      ->capture_default_str();
  verb->add_flag("--json", options->json, "print JSON instead of the paper's notation");
  verb->callback([options, &exit] { exit = report(learn(*options)); });
}

}  // namespace

Result<rules::RuleSet> read_rules(const std::string& file) {
  PRIMO_ASSIGN(const std::string text, read_file(file));
  auto rules = rules::rules_from_json(text);
  if (!rules.ok()) return rules.error().at(file);
  return rules;
}

Status read_all(const std::vector<std::string>& files, bool skip_bad,
                const std::function<Status(Experience&&, const std::string&)>& use) {
  for (const auto& file : files) {
    PRIMO_ASSIGN(const auto summary, symbols::read_experience_file(file, {.skip_bad = skip_bad}, use));
    if (summary.skipped == 0) continue;
    std::cerr << "primo: " << file << ": " << summary.skipped << " lines skipped, " << summary.experiences
              << " used; the first: " << summary.first_skipped << "\n";
  }
  return success();
}

Status read_all_for(const rules::RuleSet& rules, const std::vector<std::string>& files, bool skip_bad,
                    const std::function<Status(Experience&&, const std::string&)>& use) {
  symbols::Signatures signatures;
  for (const auto& rule : rules.rules) {
    PRIMO_TRY(signatures.add_action(rule.action, "the rules"));
    for (const auto& literal : rule.context) PRIMO_TRY(signatures.add(literal, "the rules"));
    for (const auto& outcome : rule.outcomes) {
      for (const auto& literal : outcome.literals) PRIMO_TRY(signatures.add(literal, "the rules"));
    }
  }
  return read_all(files, skip_bad, [&](Experience&& experience, const std::string& where) -> Status {
    PRIMO_TRY(signatures.add(experience, where));
    return use(std::move(experience), where);
  });
}

void add_rules(CLI::App& app, int& exit) {
  auto* rules =
      app.add_subcommand("rules", "NID rules: learn them from experiences, ask them, show them, plan with them");
  rules->require_subcommand(1);
  add_learn(*rules, exit);

  const auto predict_options = std::make_shared<Options>(), score_options = std::make_shared<Options>();
  auto* predict_verb = rules->add_subcommand("predict", "prints what the rules predict for each experience's (s, a)");
  predict_verb->add_option("--rules", predict_options->rules, "rules as JSON")->required();
  add_experiences(*predict_verb, *predict_options);
  predict_verb->callback([predict_options, &exit] { exit = report(predict(*predict_options)); });

  auto* score_verb = rules->add_subcommand("score", "prints the rules' log-likelihood, penalty and score");
  score_verb->add_option("--rules", score_options->rules, "rules as JSON")->required();
  add_experiences(*score_verb, *score_options);
  add_score_options(*score_verb, *score_options);
  score_verb->callback([score_options, &exit] { exit = report(score(*score_options)); });

  add_rules_use(*rules, exit);
}

}  // namespace primo::tool
