#include "symbols/literal.h"

#include <algorithm>

#include "symbols/literal_json.h"

namespace primo::symbols {
namespace {

// {"objects":[…],"s":[["on","c1","t"]]}: object, array, literal.
constexpr int kExperienceDepth = 4;

Error data(std::string message) { return {Code::data, std::move(message)}; }

Json state_to_json(const State& state) {
  Json json = Json::array();
  for (const auto& literal : state) json.push_back(literal_to_json(literal));
  return json;
}

Result<State> state_from_json(const Json& json, const std::string& key) {
  if (!json.is_array()) return data("\"" + key + "\" is not a list of literals");
  State state;
  for (const auto& item : json) {
    auto literal = literal_from_json(item);
    if (!literal.ok()) return literal.error().at(key);
    if (!state.insert(*literal).second) return data(key + ": " + literal->text() + " stands twice");
  }
  return state;
}

Status check_ground(const Literal& literal, const std::set<std::string>& objects, const std::string& where) {
  if (literal.negated) return data(where + ": " + literal.text() + " is negated; list only what holds");
  if (!is_name(literal.predicate)) return data(where + ": \"" + literal.predicate + "\" cannot name a predicate");
  if (literal.arguments.size() > kMaxArity) {
    return data(where + ": " + literal.text() + " has more than " + std::to_string(kMaxArity) + " arguments");
  }
  for (const auto& argument : literal.arguments) {
    if (!objects.contains(argument)) {
      return data(where + ": " + literal.text() + " mentions " + argument + ", which is not among the objects");
    }
  }
  return success();
}

}  // namespace

std::string Literal::text() const {
  std::string text = negated ? "¬" : "";
  text += predicate;
  if (arguments.empty()) return text;
  text += "(";
  for (std::size_t i = 0; i < arguments.size(); ++i) text += (i ? "," : "") + arguments[i];
  text += ")";
  return text;
}

bool is_variable(const std::string& term) { return !term.empty() && term[0] >= 'A' && term[0] <= 'Z'; }

Status validate(const Experience& experience) {
  std::set<std::string> objects;
  for (const auto& object : experience.objects) {
    if (!is_name(object)) return data("objects: \"" + object + "\" cannot name an object");
    if (is_variable(object)) {
      return data("objects: " + object + " begins with a capital, which only variables do; write it in lower case");
    }
    if (!objects.insert(object).second) return data("objects: " + object + " stands twice");
  }
  for (const auto& literal : experience.before) PRIMO_TRY(check_ground(literal, objects, "s"));
  PRIMO_TRY(check_ground(experience.action, objects, "a"));
  for (const auto& literal : experience.after) PRIMO_TRY(check_ground(literal, objects, "s2"));
  return success();
}

std::string to_json_line(const Experience& experience) {
  Json json = Json::object();
  if (!experience.id.empty()) json["id"] = experience.id;
  json["objects"] = experience.objects;
  json["s"] = state_to_json(experience.before);
  json["a"] = literal_to_json(experience.action);
  json["s2"] = state_to_json(experience.after);
  return dump(json);
}

Result<Experience> experience_from_json(const std::string& line) {
  PRIMO_ASSIGN(const Json json, parse_json(line, kExperienceDepth));
  if (!json.is_object()) return data("an experience is an object with the keys objects, s, a and s2");
  PRIMO_TRY(check_keys(json, {"id", "objects", "s", "a", "s2"}));
  for (const char* key : {"objects", "s", "a", "s2"}) {
    if (!json.contains(key)) return data("the experience lacks the key \"" + std::string(key) + "\"");
  }
  Experience experience;
  if (json.contains("id")) {
    if (!json["id"].is_string()) return data("\"id\" is not a string");
    experience.id = json["id"].get<std::string>();
  }
  if (!json["objects"].is_array()) return data("\"objects\" is not a list of names");
  for (const auto& object : json["objects"]) {
    if (!object.is_string()) return data("\"objects\" holds " + dump(object).substr(0, 80) + ", which is not a name");
    experience.objects.push_back(object.get<std::string>());
  }
  PRIMO_ASSIGN(experience.before, state_from_json(json["s"], "s"));
  auto action = literal_from_json(json["a"]);
  if (!action.ok()) return action.error().at("a");
  experience.action = *action;
  PRIMO_ASSIGN(experience.after, state_from_json(json["s2"], "s2"));
  PRIMO_TRY(validate(experience));
  return experience;
}

}  // namespace primo::symbols
