#include "symbols/literal.h"

#include <algorithm>
#include <limits>

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

Result<std::vector<std::string>> objects_from_json(const Json& json) {
  if (!json.is_array()) return data("\"objects\" is not a list of names");
  std::vector<std::string> objects;
  for (const auto& object : json) {
    if (!object.is_string()) return data("\"objects\" holds " + dump(object).substr(0, 80) + ", which is not a name");
    objects.push_back(object.get<std::string>());
  }
  return objects;
}

Status check_single_values(const State& state, const std::string& where) {
  const Literal* last = nullptr;
  for (const auto& literal : state) {
    if (last && literal.relation == Relation::equal && last->relation == Relation::equal &&
        last->predicate == literal.predicate && last->arguments == literal.arguments) {
      return data(where + ": both " + last->text() + " and " + literal.text() + "; a function has one value");
    }
    last = &literal;
  }
  return success();
}

Status check_ground(const Literal& literal, const std::set<std::string>& objects, const std::string& where) {
  if (literal.negated) return data(where + ": " + literal.text() + " is negated; list only what holds");
  if (literal.relation == Relation::at_least || literal.relation == Relation::at_most) {
    return data(where + ": " + literal.text() + " is a range; a state gives the value");
  }
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
  const bool unequal = negated && relation == Relation::equal;
  std::string text = negated && !unequal ? "¬" : "";
  text += predicate;
  if (!arguments.empty()) {
    text += "(";
    for (std::size_t i = 0; i < arguments.size(); ++i) text += (i ? "," : "") + arguments[i];
    text += ")";
  }
  if (relation == Relation::none) return text;
  text += unequal ? "≠" : relation == Relation::equal ? "=" : relation == Relation::at_least ? "≥" : "≤";
  return text + std::to_string(value);
}

std::optional<std::int32_t> value_of(const State& state, const std::string& function,
                                     const std::vector<std::string>& arguments) {
  const auto at =
      state.lower_bound({function, arguments, false, Relation::equal, std::numeric_limits<std::int32_t>::min()});
  if (at == state.end() || at->predicate != function || at->arguments != arguments || at->negated ||
      at->relation != Relation::equal) {
    return std::nullopt;
  }
  return at->value;
}

bool holds(const Literal& literal, const State& state) {
  if (literal.relation == Relation::none) {
    if (!literal.negated) return state.contains(literal);
    Literal positive = literal;
    positive.negated = false;
    return !state.contains(positive);
  }
  const auto value = value_of(state, literal.predicate, literal.arguments);
  const bool compares = value && (literal.relation == Relation::equal      ? *value == literal.value
                                  : literal.relation == Relation::at_least ? *value >= literal.value
                                                                           : *value <= literal.value);
  return compares != literal.negated;
}

void make_true(const Literal& literal, State& state) {
  Literal positive = literal;
  positive.negated = false;
  if (literal.relation == Relation::equal) {
    const auto old = value_of(state, literal.predicate, literal.arguments);
    if (old && (!literal.negated || *old == literal.value)) {
      state.erase({literal.predicate, literal.arguments, false, Relation::equal, *old});
    }
    if (!literal.negated) state.insert(std::move(positive));
  } else if (literal.negated) {
    state.erase(positive);
  } else {
    state.insert(std::move(positive));
  }
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
  if (experience.action.relation != Relation::none) return data("a: " + experience.action.text() + " has a value");
  for (const auto& literal : experience.after) PRIMO_TRY(check_ground(literal, objects, "s2"));
  PRIMO_TRY(check_single_values(experience.before, "s"));
  return check_single_values(experience.after, "s2");
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
  PRIMO_ASSIGN(experience.objects, objects_from_json(json["objects"]));
  PRIMO_ASSIGN(experience.before, state_from_json(json["s"], "s"));
  auto action = literal_from_json(json["a"]);
  if (!action.ok()) return action.error().at("a");
  experience.action = *action;
  PRIMO_ASSIGN(experience.after, state_from_json(json["s2"], "s2"));
  PRIMO_TRY(validate(experience));
  return experience;
}

Result<Situation> situation_from_json(const std::string& text) {
  PRIMO_ASSIGN(const Json json, parse_json(text, kExperienceDepth));
  if (!json.is_object()) return data("a situation is an object with the keys objects and s");
  PRIMO_TRY(check_keys(json, {"id", "objects", "s", "a", "s2"}));
  for (const char* key : {"objects", "s"}) {
    if (!json.contains(key)) return data("the situation lacks the key \"" + std::string(key) + "\"");
  }
  Experience whole;
  PRIMO_ASSIGN(whole.objects, objects_from_json(json["objects"]));
  PRIMO_ASSIGN(whole.before, state_from_json(json["s"], "s"));
  whole.action.predicate = "none";
  PRIMO_TRY(validate(whole));
  return Situation{std::move(whole.objects), std::move(whole.before)};
}

}  // namespace primo::symbols
