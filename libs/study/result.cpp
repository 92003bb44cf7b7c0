#include "study/result.h"

#include <algorithm>
#include <set>
#include <utility>

#include "core/files.h"
#include "study/json_io.h"

namespace primo::study {
namespace {

using json::Json;

Json to_json(const Rates& rates) {
  Json all = {{"final_pose", json::rate(rates.final_pose)},
              {"strict", json::rate(rates.strict)},
              {"desired", json::rate(rates.desired)},
              {"gamma", json::number(rates.gamma)},
              {"outcomes", Json(rates.outcomes)}};
  if (!rates.on.empty()) all["on"] = Json(rates.on);
  return all;
}

void get_counts(const Json& at, const std::string& name, std::map<std::string, int>& counts) {
  const Json& found = json::field(at, name.c_str());
  if (!found.is_object()) throw json::Malformed{"'" + name + "' must be an object"};
  for (const auto& [key, count] : found.items()) {
    if (!count.is_number_integer()) throw json::Malformed{"'" + name + "." + key + "' must be a whole number"};
    counts[key] = count.get<int>();
  }
}

Rates rates_from(const Json& at) {
  Rates rates;
  json::get(at, "final_pose", rates.final_pose);
  json::get(at, "strict", rates.strict);
  json::get(at, "desired", rates.desired);
  json::get(at, "gamma", rates.gamma);
  get_counts(at, "outcomes", rates.outcomes);
  if (at.contains("on")) get_counts(at, "on", rates.on);
  return rates;
}

Json to_json(const Collection& collection) {
  return {{"primitive", collection.primitive.name},
          {"primitive_yaml", config::dump(collection.primitive)},
          {"training", to_json(collection.training)},
          {"displaced", to_json(collection.displaced)},
          {"executed", json::rate(collection.executed)},
          {"executed_of_strict", json::rate(collection.executed_of_strict)},
          {"rules", Json::parse(rules::to_json(collection.rules))},
          {"untested_context", json::literals(collection.untested_context)}};
}

Collection collection_from(const Json& at) {
  Collection collection;
  std::string yaml;
  json::get(at, "primitive_yaml", yaml);
  auto primitive = config::read_text<motion::Primitive>(yaml, "primitive");
  if (!primitive) throw json::Malformed{primitive.error().message};
  collection.primitive = std::move(*primitive);
  collection.training = rates_from(json::field(at, "training"));
  collection.displaced = rates_from(json::field(at, "displaced"));
  json::get(at, "executed", collection.executed);
  json::get(at, "executed_of_strict", collection.executed_of_strict);
  auto rules = rules::rules_from_json(symbols::dump(json::field(at, "rules")));
  if (!rules) throw json::Malformed{"rules: " + rules.error().message};
  collection.rules = std::move(*rules);
  json::get(at, "untested_context", collection.untested_context);
  return collection;
}

/// A rule's action, context and outcomes without their probabilities: what its structure is.
std::string structure(const rules::Rule& rule) {
  std::string text = rule.action.text() + ":";
  std::set<symbols::Literal> context(rule.context.begin(), rule.context.end());
  for (const auto& literal : context) text.append(" ").append(literal.text());
  std::set<std::string> outcomes;
  for (const auto& outcome : rule.outcomes) {
    std::string one = " |";
    for (const auto& literal : std::set<symbols::Literal>(outcome.literals.begin(), outcome.literals.end()))
      one.append(" ").append(literal.text());
    outcomes.insert(one);
  }
  for (const auto& outcome : outcomes) text += outcome;
  return text;
}

std::set<symbols::Literal> as_set(const std::vector<symbols::Literal>& literals) {
  return {literals.begin(), literals.end()};
}

bool outside(double p, const Rate& rate) { return p < rate.lower() || p > rate.upper(); }

/// Whether two counts of the same outcome cannot be told apart: each probability lies in the other's interval.
bool probability_changed(const Rate& a, const Rate& b) { return outside(a.value(), b) || outside(b.value(), a); }

}  // namespace

std::string to_json(const StudyResult& result) {
  Json collections = Json::array();
  for (const auto& collection : result.collections) collections.push_back(to_json(collection));
  Json optimizations = Json::array();
  for (const auto& optimization : result.optimizations) {
    optimizations.push_back({{"desired", json::literals(optimization.desired)},
                             {"gamma", json::number(optimization.gamma)},
                             {"success", json::rate(optimization.success)},
                             {"evaluations", optimization.evaluations}});
  }
  const Json all = {{"study", result.study},
                    {"action", result.action},
                    {"collections", std::move(collections)},
                    {"optimizations", std::move(optimizations)},
                    {"end", result.end}};
  return all.dump(1, ' ', false, Json::error_handler_t::replace) + "\n";
}

Result<StudyResult> result_from_json(const std::string& text) {
  return json::decode(text, "study result", [](const Json& at) {
    StudyResult result;
    json::get(at, "study", result.study);
    json::get(at, "action", result.action);
    for (const auto& collection : json::array(at, "collections"))
      result.collections.push_back(collection_from(collection));
    for (const auto& o : json::array(at, "optimizations")) {
      Optimization optimization;
      json::get(o, "desired", optimization.desired);
      json::get(o, "gamma", optimization.gamma);
      json::get(o, "success", optimization.success);
      json::get(o, "evaluations", optimization.evaluations);
      result.optimizations.push_back(std::move(optimization));
    }
    json::get(at, "end", result.end);
    return result;
  });
}

Result<StudyResult> read_result(const std::filesystem::path& directory) {
  const auto file = directory / "result.json";
  PRIMO_ASSIGN(const std::string text, read_file(file));
  auto result = result_from_json(text);
  if (!result) return result.error().at(file.string());
  return result;
}

const rules::Rule* rule_of(const rules::RuleSet& rules, const std::string& action) {
  const rules::Rule* found = nullptr;
  for (const auto& rule : rules.rules) {
    if (rule.action.predicate == action && (found == nullptr || rule.trials() > found->trials())) found = &rule;
  }
  return found;
}

bool rules_changed(const rules::RuleSet& before, const rules::RuleSet& after) {
  std::map<std::string, const rules::Rule*> old_rules, new_rules;
  for (const auto& rule : before.rules) old_rules[structure(rule)] = &rule;
  for (const auto& rule : after.rules) new_rules[structure(rule)] = &rule;
  if (old_rules.size() != new_rules.size()) return true;
  for (const auto& [text, rule] : old_rules) {
    const auto other = new_rules.find(text);
    if (other == new_rules.end()) return true;
    for (const auto& outcome : rule->outcomes) {
      const auto same =
          std::find_if(other->second->outcomes.begin(), other->second->outcomes.end(),
                       [&](const rules::RuleOutcome& o) { return as_set(o.literals) == as_set(outcome.literals); });
      if (probability_changed({outcome.count, rule->trials()}, {same->count, other->second->trials()})) return true;
    }
  }
  return false;
}

}  // namespace primo::study
