// JSON of the study's records. Private to libs/study.
#pragma once

#include <Eigen/Core>
#include <cmath>
#include <cstdint>
#include <limits>
#include <string>
#include <vector>

#include "config/config.h"
#include "core/pose.h"
#include "core/statistics.h"
#include "symbols/literal_json.h"

namespace primo::study::json {

using Json = symbols::Json;

/// What a decoder throws on data of the wrong form; decode() turns it into an Error.
struct Malformed {
  std::string message;
};

/// A double; JSON has no infinities, so these are words.
inline Json number(double value) {
  if (std::isfinite(value)) return value;
  return std::isnan(value) ? "nan" : value > 0 ? "inf" : "-inf";
}

inline const Json& field(const Json& object, const char* name) {
  if (!object.is_object()) throw Malformed{std::string("expected an object with '") + name + "'"};
  const auto at = object.find(name);
  if (at == object.end()) throw Malformed{std::string("missing '") + name + "'"};
  return *at;
}

inline double to_double(const Json& value, const char* name) {
  if (value.is_number()) return value.get<double>();
  if (value == "inf") return std::numeric_limits<double>::infinity();
  if (value == "-inf") return -std::numeric_limits<double>::infinity();
  if (value == "nan") return std::numeric_limits<double>::quiet_NaN();
  throw Malformed{std::string("'") + name + "' must be a number"};
}

inline void get(const Json& object, const char* name, double& value) { value = to_double(field(object, name), name); }
inline void get(const Json& object, const char* name, std::string& value) {
  const Json& at = field(object, name);
  if (!at.is_string()) throw Malformed{std::string("'") + name + "' must be text"};
  value = at.get<std::string>();
}
inline void get(const Json& object, const char* name, bool& value) {
  const Json& at = field(object, name);
  if (!at.is_boolean()) throw Malformed{std::string("'") + name + "' must be true or false"};
  value = at.get<bool>();
}
inline void get(const Json& object, const char* name, std::int64_t& value) {
  const Json& at = field(object, name);
  if (!at.is_number_integer()) throw Malformed{std::string("'") + name + "' must be a whole number"};
  value = at.get<std::int64_t>();
}
inline void get(const Json& object, const char* name, int& value) {
  std::int64_t wide = 0;
  get(object, name, wide);
  if (wide < std::numeric_limits<int>::min() || wide > std::numeric_limits<int>::max()) {
    throw Malformed{std::string("'") + name + "' is out of range"};
  }
  value = static_cast<int>(wide);
}
template <class E>
requires std::is_enum_v<E>
void get(const Json& object, const char* name, E& value) {
  std::string text;
  get(object, name, text);
  for (std::size_t i = 0; i < config::EnumNames<E>::names.size(); ++i) {
    if (config::EnumNames<E>::names[i] == text) {
      value = static_cast<E>(i);
      return;
    }
  }
  throw Malformed{std::string("'") + name + "' has the unknown value '" + text + "'"};
}

inline const Json& array(const Json& object, const char* name) {
  const Json& at = field(object, name);
  if (!at.is_array()) throw Malformed{std::string("'") + name + "' must be a list"};
  return at;
}

inline Json strings(const std::vector<std::string>& values) {
  Json list = Json::array();
  for (const auto& value : values) list.push_back(value);
  return list;
}
inline void get(const Json& object, const char* name, std::vector<std::string>& values) {
  values.clear();
  for (const auto& value : array(object, name)) {
    if (!value.is_string()) throw Malformed{std::string("'") + name + "' must be a list of texts"};
    values.push_back(value.get<std::string>());
  }
}
inline Json doubles(const std::vector<double>& values) {
  Json list = Json::array();
  for (const double value : values) list.push_back(number(value));
  return list;
}
inline void get(const Json& object, const char* name, std::vector<double>& values) {
  values.clear();
  for (const auto& value : array(object, name)) values.push_back(to_double(value, name));
}

template <class V>
Json vector(const V& values) {
  Json list = Json::array();
  for (int i = 0; i < values.size(); ++i) list.push_back(number(values(i)));
  return list;
}
template <int N>
void get(const Json& object, const char* name, Eigen::Matrix<double, N, 1>& value) {
  const Json& list = array(object, name);
  if (list.size() != static_cast<std::size_t>(N))
    throw Malformed{std::string("'") + name + "' must have " + std::to_string(N) + " numbers"};
  for (int i = 0; i < N; ++i) value(i) = to_double(list[static_cast<std::size_t>(i)], name);
}

/// A pose as the 12 numbers of its upper rows, so that it reads back to the same bits.
inline Json pose(const Pose& X) {
  Json list = Json::array();
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 4; ++column) list.push_back(number(X.matrix()(row, column)));
  }
  return list;
}
inline void get(const Json& object, const char* name, Pose& X) {
  const Json& list = array(object, name);
  if (list.size() != 12) throw Malformed{std::string("'") + name + "' must have 12 numbers"};
  X = Pose::Identity();
  for (std::size_t i = 0; i < 12; ++i)
    X.matrix()(static_cast<int>(i / 4), static_cast<int>(i % 4)) = to_double(list[i], name);
}

inline Json rate(const Rate& value) { return {{"successes", value.successes}, {"trials", value.trials}}; }
inline void get(const Json& object, const char* name, Rate& value) {
  const Json& at = field(object, name);
  get(at, "successes", value.successes);
  get(at, "trials", value.trials);
  if (value.successes < 0 || value.trials < value.successes)
    throw Malformed{std::string("'") + name + "' is not a rate"};
}

inline Json literals(const std::vector<symbols::Literal>& values) {
  Json list = Json::array();
  for (const auto& value : values) list.push_back(symbols::literal_to_json(value));
  return list;
}
inline void get(const Json& object, const char* name, std::vector<symbols::Literal>& values) {
  values.clear();
  for (const auto& value : array(object, name)) {
    auto literal = symbols::literal_from_json(value);
    if (!literal) throw Malformed{std::string("'") + name + "': " + literal.error().message};
    values.push_back(std::move(*literal));
  }
}
inline Json state(const symbols::State& values) { return literals({values.begin(), values.end()}); }
inline void get(const Json& object, const char* name, symbols::State& values) {
  std::vector<symbols::Literal> list;
  get(object, name, list);
  values = {list.begin(), list.end()};
}

/// Parses `text` and runs `read(json)`; a malformed text or field becomes an Error (data) that begins with `what`.
template <class F>
auto decode(const std::string& text, const char* what, F&& read)
    -> Result<decltype(read(std::declval<const Json&>()))> {
  auto parsed = symbols::parse_json(text, 64);
  if (!parsed) return parsed.error().at(what);
  try {
    return read(*parsed);
  } catch (const Malformed& malformed) {
    return Error{Code::data, std::string(what) + ": " + malformed.message};
  }
}

}  // namespace primo::study::json
