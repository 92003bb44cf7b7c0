#include "study/result.h"

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

rules::RuleSet rules_from(const Json& at) {
  auto rules = rules::rules_from_json(symbols::dump(at));
  if (!rules) throw json::Malformed{"rules: " + rules.error().message};
  return std::move(*rules);
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
  collection.rules = rules_from(json::field(at, "rules"));
  json::get(at, "untested_context", collection.untested_context);
  return collection;
}

Json to_json(const Paired& pair) {
  return {{"both", pair.both},
          {"first_only", pair.first_only},
          {"second_only", pair.second_only},
          {"neither", pair.neither}};
}

Paired paired_from(const Json& at) {
  Paired pair;
  json::get(at, "both", pair.both);
  json::get(at, "first_only", pair.first_only);
  json::get(at, "second_only", pair.second_only);
  json::get(at, "neither", pair.neither);
  return pair;
}

Json to_json(const std::map<std::string, Example>& examples) {
  Json all = Json::object();
  for (const auto& [cause, example] : examples) all[cause] = {{"count", example.count}, {"scenario", example.scenario}};
  return all;
}

std::map<std::string, Example> examples_from(const Json& at) {
  if (!at.is_object()) throw json::Malformed{"failures must be an object"};
  std::map<std::string, Example> examples;
  for (const auto& [cause, example] : at.items()) {
    json::get(example, "count", examples[cause].count);
    json::get(example, "scenario", examples[cause].scenario);
  }
  return examples;
}

Json to_json(const LevelRates& rates) {
  Json all = {
      {"final_pose", json::rate(rates.final_pose)}, {"strict", json::rate(rates.strict)},
      {"executed", json::rate(rates.executed)},     {"executed_of_strict", json::rate(rates.executed_of_strict)},
      {"failures", to_json(rates.failures)},        {"not_executed", to_json(rates.not_executed)}};
  if (rates.rules) all["rules"] = Json::parse(rules::to_json(*rates.rules));
  if (rates.executed_rules) all["executed_rules"] = Json::parse(rules::to_json(*rates.executed_rules));
  return all;
}

LevelRates level_rates_from(const Json& at) {
  LevelRates rates;
  json::get(at, "final_pose", rates.final_pose);
  json::get(at, "strict", rates.strict);
  json::get(at, "executed", rates.executed);
  json::get(at, "executed_of_strict", rates.executed_of_strict);
  rates.failures = examples_from(json::field(at, "failures"));
  rates.not_executed = examples_from(json::field(at, "not_executed"));
  if (at.contains("rules")) rates.rules = rules_from(at.at("rules"));
  if (at.contains("executed_rules")) rates.executed_rules = rules_from(at.at("executed_rules"));
  return rates;
}

Json to_json(const Level& level) {
  return {{"displacement", json::number(level.displacement)},
          {"rejected_touching", level.rejected_touching},
          {"rejected_falling", level.rejected_falling},
          {"rejected_in_robot", level.rejected_in_robot},
          {"before", to_json(level.before)},
          {"after", to_json(level.after)},
          {"paired",
           {{"final_pose", to_json(level.final_pose)},
            {"strict", to_json(level.strict)},
            {"executed", to_json(level.executed)}}}};
}

Level level_from(const Json& at) {
  Level level;
  json::get(at, "displacement", level.displacement);
  json::get(at, "rejected_touching", level.rejected_touching);
  json::get(at, "rejected_falling", level.rejected_falling);
  json::get(at, "rejected_in_robot", level.rejected_in_robot);
  level.before = level_rates_from(json::field(at, "before"));
  level.after = level_rates_from(json::field(at, "after"));
  const Json& pairs = json::field(at, "paired");
  level.final_pose = paired_from(json::field(pairs, "final_pose"));
  level.strict = paired_from(json::field(pairs, "strict"));
  level.executed = paired_from(json::field(pairs, "executed"));
  return level;
}

Json to_json(const PartResult& part) {
  Json collections = Json::array(), optimizations = Json::array(), levels = Json::array();
  for (const auto& collection : part.collections) collections.push_back(to_json(collection));
  for (const auto& optimization : part.optimizations) {
    optimizations.push_back({{"desired", json::literals(optimization.desired)},
                             {"gamma", json::number(optimization.gamma)},
                             {"success", json::rate(optimization.success)},
                             {"evaluations", optimization.evaluations}});
  }
  for (const auto& level : part.levels) levels.push_back(to_json(level));
  return {{"name", part.name},
          {"action", part.action},
          {"collections", std::move(collections)},
          {"optimizations", std::move(optimizations)},
          {"end", part.end},
          {"levels", std::move(levels)}};
}

PartResult part_from(const Json& at) {
  PartResult part;
  json::get(at, "name", part.name);
  json::get(at, "action", part.action);
  for (const auto& collection : json::array(at, "collections")) part.collections.push_back(collection_from(collection));
  for (const auto& o : json::array(at, "optimizations")) {
    Optimization optimization;
    json::get(o, "desired", optimization.desired);
    json::get(o, "gamma", optimization.gamma);
    json::get(o, "success", optimization.success);
    json::get(o, "evaluations", optimization.evaluations);
    part.optimizations.push_back(std::move(optimization));
  }
  json::get(at, "end", part.end);
  for (const auto& level : json::array(at, "levels")) part.levels.push_back(level_from(level));
  return part;
}

}  // namespace

std::string to_json(const StudyResult& result) {
  Json parts = Json::array();
  for (const auto& part : result.parts) parts.push_back(to_json(part));
  const Json all = {{"study", result.study}, {"parts", std::move(parts)}};
  return all.dump(1, ' ', false, Json::error_handler_t::replace) + "\n";
}

Result<StudyResult> result_from_json(const std::string& text) {
  return json::decode(text, "study result", [](const Json& at) {
    StudyResult result;
    json::get(at, "study", result.study);
    for (const auto& part : json::array(at, "parts")) result.parts.push_back(part_from(part));
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

}  // namespace primo::study
