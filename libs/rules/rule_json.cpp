// Rules in JSON: {"rules":[{"action":["grasp","X"],"context":[["on","X","Y"],["not","wet"]],
//   "outcomes":[[0.94,[["inhand","X"],["not","on","X","Y"]]]],"noise":0.06,"counts":[47,3]}],
//   "default":{"grasp":{"nochange":0.9,"noise":0.1,"counts":[9,1]}}}
// "derived" lists definitions of predicates, when there are any. The counts are the outcomes' and then the noise's. A
// rule has "examples" when these differ from the sum of its counts.
#include <cmath>

#include "rules/rule.h"
#include "symbols/literal_json.h"
#include "symbols/signatures.h"

namespace primo::rules {
namespace {

using symbols::check_keys;
using symbols::is_variable;
using symbols::Json;
using symbols::Literal;
using symbols::literal_from_json;
using symbols::literal_to_json;

// {"rules":[{"outcomes":[[p,[["inhand","X"]]]]}]}: object, list, rule, outcomes, outcome, literals, literal.
constexpr int kRulesDepth = 8;
constexpr double kSumTolerance = 1e-6;     // of probabilities written with few digits by other programs
constexpr std::size_t kMaxVariables = 32;  // every deictic variable multiplies the work of binding

Error data(std::string message) { return {Code::data, std::move(message)}; }

Json literals_to_json(const std::vector<Literal>& literals) {
  Json json = Json::array();
  for (const auto& literal : literals) json.push_back(literal_to_json(literal));
  return json;
}

Result<std::vector<Literal>> literals_from_json(const Json& json, const std::string& where) {
  if (!json.is_array()) return data(where + " is not a list of literals");
  std::vector<Literal> literals;
  for (const auto& item : json) {
    auto literal = literal_from_json(item);
    if (!literal.ok()) return literal.error().at(where);
    literals.push_back(*literal);
  }
  return literals;
}

Result<double> probability(const Json& json, const std::string& where) {
  if (!json.is_number() || !(json.get<double>() >= 0) || !(json.get<double>() <= 1)) {
    return data(where + " is " + symbols::dump(json).substr(0, 40) + "; a probability is a number from 0 to 1");
  }
  return json.get<double>();
}

Result<std::int64_t> count(const Json& json, const std::string& where) {
  constexpr std::int64_t kMost = std::int64_t{1} << 40;
  if (!json.is_number_integer() || json.get<double>() < 0 || json.get<double>() > static_cast<double>(kMost)) {
    return data(where + " is " + symbols::dump(json).substr(0, 40) + "; a count is a whole number, 0 or more");
  }
  return json.get<std::int64_t>();
}

Status check_sum(double sum, const std::string& where) {
  if (std::abs(sum - 1) <= kSumTolerance) return success();
  return data(where + ": the probabilities sum to " + std::to_string(sum) + ", not to 1");
}

/// Outcomes may only mention what the action and the context bind.
Status check_variables(const Rule& rule) {
  std::set<std::string> bound;
  const auto add = [&](const Literal& literal) {
    for (const auto& argument : literal.arguments) {
      if (is_variable(argument)) bound.insert(argument);
    }
  };
  add(rule.action);
  for (const auto& literal : rule.context) add(literal);
  if (bound.size() > kMaxVariables) {
    return data("more than " + std::to_string(kMaxVariables) + " variables in one rule");
  }
  for (const auto& outcome : rule.outcomes) {
    for (const auto& literal : outcome.literals) {
      for (const auto& argument : literal.arguments) {
        if (is_variable(argument) && !bound.contains(argument)) {
          return data("outcomes: " + literal.text() + " mentions " + argument +
                      ", which neither the action nor the context binds");
        }
      }
    }
  }
  return success();
}

Status read_outcomes(const Json& json, Rule& rule) {
  if (!json.is_array()) return data("outcomes: not a list of [probability, literals]");
  for (std::size_t i = 0; i < json.size(); ++i) {
    const std::string where = "outcomes[" + std::to_string(i) + "]";
    if (!json[i].is_array() || json[i].size() != 2) return data(where + ": not [probability, literals]");
    RuleOutcome outcome;
    PRIMO_ASSIGN(outcome.p, probability(json[i][0], where));
    PRIMO_ASSIGN(outcome.literals, literals_from_json(json[i][1], where));
    rule.outcomes.push_back(std::move(outcome));
  }
  return success();
}

Status read_counts(const Json& json, Rule& rule) {
  if (json.contains("counts")) {
    const auto& counts = json["counts"];
    if (!counts.is_array() || counts.size() != rule.outcomes.size() + 1) {
      return data("counts: must be a list of one count for each of the " + std::to_string(rule.outcomes.size()) +
                  " outcomes and one for noise");
    }
    for (std::size_t i = 0; i < rule.outcomes.size(); ++i) {
      PRIMO_ASSIGN(rule.outcomes[i].count, count(counts[i], "counts[" + std::to_string(i) + "]"));
    }
    PRIMO_ASSIGN(rule.noise_count, count(counts[rule.outcomes.size()], "the count of noise"));
  }
  const std::int64_t sum = rule.trials();
  if (json.contains("examples")) {
    PRIMO_ASSIGN(rule.examples, count(json["examples"], "examples"));
    if (rule.examples > sum) return data("examples: more than the counts explain (" + std::to_string(sum) + ")");
    for (const auto& outcome : rule.outcomes) {
      if (outcome.count > rule.examples) return data("counts: an outcome counts more than all examples");
    }
  } else {
    rule.examples = sum;
  }
  return success();
}

Result<Rule> rule_from_json(const Json& json) {
  if (!json.is_object()) return data("not an object");
  PRIMO_TRY(check_keys(json, {"action", "context", "outcomes", "noise", "counts", "examples"}));
  for (const char* key : {"action", "context", "outcomes", "noise"}) {
    if (!json.contains(key)) return data("lacks the key \"" + std::string(key) + "\"");
  }
  Rule rule;
  auto action = literal_from_json(json["action"]);
  if (!action.ok()) return action.error().at("action");
  rule.action = *action;
  if (rule.action.relation != symbols::Relation::none) return data("action: " + rule.action.text() + " has a value");
  if (rule.action.negated) return data("action: " + rule.action.text() + " is negated");
  PRIMO_ASSIGN(rule.context, literals_from_json(json["context"], "context"));
  PRIMO_TRY(read_outcomes(json["outcomes"], rule));
  PRIMO_ASSIGN(rule.noise, probability(json["noise"], "noise"));
  PRIMO_TRY(read_counts(json, rule));
  double sum = rule.noise;
  for (const auto& outcome : rule.outcomes) sum += outcome.p;
  PRIMO_TRY(check_sum(sum, "outcomes and noise"));
  PRIMO_TRY(check_variables(rule));
  return rule;
}

Result<DefaultRule> default_from_json(const Json& json) {
  if (!json.is_object()) return data("not an object");
  PRIMO_TRY(check_keys(json, {"nochange", "noise", "counts"}));
  if (!json.contains("nochange") || !json.contains("noise")) return data("must have the keys nochange and noise");
  DefaultRule rule;
  PRIMO_ASSIGN(rule.no_change, probability(json["nochange"], "nochange"));
  PRIMO_ASSIGN(rule.noise, probability(json["noise"], "noise"));
  PRIMO_TRY(check_sum(rule.no_change + rule.noise, "nochange and noise"));
  if (json.contains("counts")) {
    const auto& counts = json["counts"];
    if (!counts.is_array() || counts.size() != 2) return data("counts: not [no change, noise]");
    PRIMO_ASSIGN(rule.no_change_count, count(counts[0], "counts[0]"));
    PRIMO_ASSIGN(rule.noise_count, count(counts[1], "counts[1]"));
  }
  return rule;
}

Result<std::vector<symbols::Definition>> derived_from_json(const Json& json) {
  if (!json.is_array())
    return data("\"derived\" must be a list of definitions such as \"clear(X) := not exists Y: on(Y,X)\"");
  std::vector<symbols::Definition> definitions;
  for (std::size_t i = 0; i < json.size(); ++i) {
    const std::string where = "derived[" + std::to_string(i) + "]";
    if (!json[i].is_string()) return data(where + " is not a text");
    auto definition = symbols::definition_from_text(json[i].get<std::string>());
    if (!definition.ok()) return definition.error().at(where);
    definitions.push_back(std::move(definition).value());
  }
  if (const auto status = symbols::check_order(definitions); !status.ok()) return status.error().at("derived");
  return definitions;
}

/// One name means one thing in all rules, and no outcome changes what is derived.
Status check_names(const RuleSet& rules) {
  symbols::Signatures signatures;
  std::set<std::string> derived;
  for (std::size_t i = 0; i < rules.derived.size(); ++i) {
    PRIMO_TRY(signatures.add(rules.derived[i].head, "derived[" + std::to_string(i) + "]"));
    derived.insert(rules.derived[i].head.predicate);
  }
  for (std::size_t i = 0; i < rules.rules.size(); ++i) {
    const std::string where = "rules[" + std::to_string(i) + "]";
    PRIMO_TRY(signatures.add_action(rules.rules[i].action, where));
    for (const auto& literal : rules.rules[i].context) PRIMO_TRY(signatures.add(literal, where));
    for (const auto& outcome : rules.rules[i].outcomes) {
      for (const auto& literal : outcome.literals) {
        PRIMO_TRY(signatures.add(literal, where));
        if (derived.contains(literal.predicate)) {
          return data(where + ": an outcome changes " + literal.text() + ", which is derived");
        }
        if (literal.relation != symbols::Relation::none && literal.relation != symbols::Relation::equal) {
          return data(where + ": the outcome " + literal.text() + " is a range; an outcome gives a value");
        }
      }
    }
  }
  return success();
}

}  // namespace

std::string to_json(const RuleSet& rules) {
  Json list = Json::array();
  for (const auto& rule : rules.rules) {
    Json json = Json::object();
    json["action"] = literal_to_json(rule.action);
    json["context"] = literals_to_json(rule.context);
    json["outcomes"] = Json::array();
    json["noise"] = rule.noise;
    json["counts"] = Json::array();
    std::int64_t sum = rule.noise_count;
    for (const auto& outcome : rule.outcomes) {
      json["outcomes"].push_back(Json::array({Json(outcome.p), literals_to_json(outcome.literals)}));
      json["counts"].push_back(outcome.count);
      sum += outcome.count;
    }
    json["counts"].push_back(rule.noise_count);
    if (rule.trials() != sum) json["examples"] = rule.trials();
    list.push_back(std::move(json));
  }
  Json defaults = Json::object();
  for (const auto& [action, rule] : rules.defaults) {
    defaults[action] = {{"nochange", rule.no_change},
                        {"noise", rule.noise},
                        {"counts", Json::array({rule.no_change_count, rule.noise_count})}};
  }
  Json json = {{"rules", std::move(list)}, {"default", std::move(defaults)}};
  if (!rules.derived.empty()) json["derived"] = Json::array();
  for (const auto& definition : rules.derived) json["derived"].push_back(definition.text());
  return symbols::dump(json);
}

Result<RuleSet> rules_from_json(const std::string& text) {
  PRIMO_ASSIGN(const Json json, symbols::parse_json(text, kRulesDepth));
  if (!json.is_object()) return data("a rule set is an object with the keys rules and default");
  PRIMO_TRY(check_keys(json, {"rules", "default", "derived"}));
  if (!json.contains("rules") || !json["rules"].is_array()) return data("\"rules\" must be a list of rules");
  RuleSet rules;
  for (std::size_t i = 0; i < json["rules"].size(); ++i) {
    auto rule = rule_from_json(json["rules"][i]);
    if (!rule.ok()) return rule.error().at("rules[" + std::to_string(i) + "]");
    rules.rules.push_back(*rule);
  }
  if (json.contains("derived")) {
    PRIMO_ASSIGN(rules.derived, derived_from_json(json["derived"]));
  }
  PRIMO_TRY(check_names(rules));
  if (!json.contains("default")) return rules;
  if (!json["default"].is_object()) return data("\"default\" must be an object with an action's name for each key");
  for (const auto& [action, value] : json["default"].items()) {
    if (!symbols::is_name(action)) return data("default: \"" + action.substr(0, 80) + "\" cannot name an action");
    auto rule = default_from_json(value);
    if (!rule.ok()) return rule.error().at("default." + action);
    rules.defaults[action] = *rule;
  }
  return rules;
}

}  // namespace primo::rules
