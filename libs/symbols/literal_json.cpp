#include "symbols/literal_json.h"

#include <algorithm>
#include <cctype>
#include <set>

namespace primo::symbols {
namespace {

constexpr std::size_t kMaxKeys = 1000;  // ordered_json looks keys up one by one

Error data(std::string message) { return {Code::data, std::move(message)}; }

/// nlohmann's text without its "[json.exception…] " mark.
std::string plain(const std::string& what) {
  const auto end = what.find("] ");
  return end == std::string::npos ? what : what.substr(end + 2);
}

/// A piece of JSON for a message, cut to a readable length.
std::string excerpt(const Json& json) {
  std::string text = dump(json);
  if (text.size() > 80) text = text.substr(0, 77) + "...";
  return text;
}

/// A function's value; far enough from the ends of its type for a bound to be moved by one.
Result<std::int32_t> fluent_value(const Json& json, const Json& literal) {
  constexpr double kMost = 1e9;
  const double value = json.get<double>();
  if (!(value >= -kMost && value <= kMost)) {
    return data("the value " + excerpt(json) + " in " + excerpt(literal) + "; a value is from -1e9 to 1e9");
  }
  return static_cast<std::int32_t>(value);
}

}  // namespace

Result<Json> parse_json(const std::string& text, int max_depth) {
  if (text.size() > kMaxJsonBytes) {
    return data("JSON of " + std::to_string(text.size()) + " bytes; at most " + std::to_string(kMaxJsonBytes) +
                " are read");
  }
  bool too_deep = false, too_many = false;
  std::string twice;
  std::vector<std::set<std::string>> keys;
  const auto watch = [&](int depth, Json::parse_event_t event, Json& parsed) {
    if (depth > max_depth) too_deep = true;
    if (too_deep || too_many) return false;
    if (event == Json::parse_event_t::object_start) keys.emplace_back();
    if (event == Json::parse_event_t::object_end) keys.pop_back();
    if (event == Json::parse_event_t::key && !keys.back().insert(parsed.get<std::string>()).second) {
      twice = parsed.get<std::string>();
    }
    if (!keys.empty() && keys.back().size() > kMaxKeys) too_many = true;
    return !too_many;
  };
  try {
    Json json = Json::parse(text, watch);
    if (too_deep) return data("JSON nested deeper than " + std::to_string(max_depth) + " levels");
    if (too_many) return data("a JSON object with more than " + std::to_string(kMaxKeys) + " keys");
    if (!twice.empty()) return data("the key \"" + twice + "\" stands twice in one object");
    return json;
  } catch (const Json::exception& e) {
    return data("not JSON: " + plain(e.what()));
  }
}

bool is_name(const std::string& name) {
  if (name.empty() || name.size() > kMaxNameBytes || name == "not") return false;
  return std::all_of(name.begin(), name.end(), [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') ||
           std::string_view("_-.:/").find(c) != std::string_view::npos;
  });
}

Json literal_to_json(const Literal& literal) {
  Json json = Json::array();
  if (literal.negated) json.push_back("not");
  if (literal.relation == Relation::at_least) json.push_back(">=");
  if (literal.relation == Relation::at_most) json.push_back("<=");
  json.push_back(literal.predicate);
  for (const auto& argument : literal.arguments) json.push_back(argument);
  if (literal.relation != Relation::none) json.push_back(literal.value);
  return json;
}

Result<Literal> literal_from_json(const Json& json) {
  const std::string right =
      "; a literal is [\"predicate\", \"argument\", ...], [\"function\", \"argument\", ..., number], or [\"not\", ...]";
  if (!json.is_array() || json.empty()) return data("not a literal: " + excerpt(json) + right);
  Literal literal;
  std::size_t at = 0;
  const auto next_is = [&](const char* word) {
    return at < json.size() && json[at].is_string() && json[at].get_ref<const std::string&>() == word;
  };
  if (next_is("not")) {
    literal.negated = true;
    ++at;
  }
  if (next_is(">=") || next_is("<=")) {
    literal.relation = next_is(">=") ? Relation::at_least : Relation::at_most;
    ++at;
  }
  std::size_t end = json.size();
  if (end > at + 1 && json[end - 1].is_number_integer()) {
    PRIMO_ASSIGN(literal.value, fluent_value(json[--end], json));
    if (literal.relation == Relation::none) literal.relation = Relation::equal;
  } else if (literal.relation != Relation::none) {
    return data("a range without its number: " + excerpt(json) + right);
  }
  if (at == end) return data("a literal without a predicate: " + excerpt(json) + right);
  for (; at < end; ++at) {
    if (!json[at].is_string() || !is_name(json[at].get_ref<const std::string&>())) {
      return data("not a name: " + excerpt(json[at]) + " in " + excerpt(json) +
                  "; names are 1 to 128 letters, digits or _ - . : / and not \"not\"");
    }
    if (literal.predicate.empty()) {
      literal.predicate = json[at].get<std::string>();
    } else {
      literal.arguments.push_back(json[at].get<std::string>());
    }
  }
  if (literal.arguments.size() > kMaxArity) {
    return data("a literal with " + std::to_string(literal.arguments.size()) + " arguments: " + excerpt(json) +
                "; at most " + std::to_string(kMaxArity) + " are supported");
  }
  return literal;
}

Status check_keys(const Json& object, std::initializer_list<const char*> known) {
  for (const auto& [key, value] : object.items()) {
    if (std::find(known.begin(), known.end(), key) != known.end()) continue;
    std::string list;
    for (const char* name : known) list += (list.empty() ? "" : ", ") + std::string(name);
    return data("unknown key \"" + key.substr(0, 80) + "\"; known: " + list);
  }
  return success();
}

std::string dump(const Json& json) { return json.dump(-1, ' ', false, Json::error_handler_t::replace); }

}  // namespace primo::symbols
