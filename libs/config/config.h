// YAML files as typed structs. A struct lists its fields once, in a template `visit`; reading, checking, the effective
// dump and the help text all come from that list:
//
//   struct Jiggle {
//     double seconds = 1.0;
//     template <class V> void visit(V&& v) {
//       v("seconds", seconds, {.help = "how long the hand is shaken", .unit = "s", .min = 0, .max = 10});
//     }
//   };
//
// Field types: bool, integers, double, std::string, Eigen vectors of fixed size, enums with EnumNames, nested structs,
// and std::optional, std::vector and std::map<std::string, ·> of these. An unknown key is refused with its line and the
// closest known key.
#pragma once

#include <yaml-cpp/yaml.h>

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cmath>
#include <concepts>
#include <filesystem>
#include <limits>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

#include "core/files.h"
#include "core/result.h"

namespace primo::config {

/// What is said of a field beside its name and default.
struct Field {
  std::string help = {};
  std::string unit = {};
  double min = -std::numeric_limits<double>::infinity();
  double max = std::numeric_limits<double>::infinity();
  bool required = false;
  std::vector<std::string> choices = {};  ///< the allowed values of a string
};

/// Specialise for an enum: `static constexpr std::array<std::string_view, N> names` in the order of values 0 … N−1.
template <class E>
struct EnumNames;

/// The name of an enum's value.
template <class E>
std::string enum_name(E value) {
  return std::string(EnumNames<E>::names[static_cast<std::size_t>(value)]);
}

struct Probe {
  template <class T>
  void operator()(const char*, T&, const Field&) {}
};
template <class T>
concept EigenVector = std::is_base_of_v<Eigen::EigenBase<T>, T>;
template <class T>
concept Visitable = !EigenVector<T> && requires(T & value, Probe& probe) {
  value.visit(probe);
};

namespace detail {

template <class T>
struct IsVector : std::false_type {};
template <class T>
struct IsVector<std::vector<T>> : std::true_type {};
template <class T>
struct IsOptional : std::false_type {};
template <class T>
struct IsOptional<std::optional<T>> : std::true_type {};
template <class T>
struct IsMap : std::false_type {};
template <class T>
struct IsMap<std::map<std::string, T>> : std::true_type {};

/// Throws the Error that read() returns; it never leaves this library.
struct Refused {
  Error error;
};
[[noreturn]] void refuse(const std::string& where, const YAML::Node& node, const std::string& message);
double number(const YAML::Node& node, const std::string& where, const std::string& key, const Field& field);
std::string closest(const std::string& word, const std::vector<std::string>& known);
std::string joined(const std::vector<std::string>& words);
/// A double as the shortest text that reads back as the same number.
std::string format(double value);

template <class T>
void read_value(const YAML::Node& node, const std::string& where, const std::string& key, const Field& field, T& value);

class Reader {
 public:
  Reader(const YAML::Node& node, std::string where, std::string prefix)
      : node_(node), where_(std::move(where)), prefix_(std::move(prefix)) {
    if (node_.IsDefined() && !node_.IsNull() && !node_.IsMap()) {
      refuse(where_, node_, (prefix_.empty() ? "the file" : prefix_) + " must be a map of keys to values");
    }
  }
  template <class T>
  void operator()(const char* name, T& value, const Field& field = {}) {
    known_.emplace_back(name);
    const YAML::Node child = node_.IsMap() ? node_[name] : YAML::Node(YAML::NodeType::Undefined);
    const std::string key = prefix_.empty() ? name : prefix_ + "." + name;
    if (!child.IsDefined()) {
      if (field.required)
        refuse(where_, node_, "missing key '" + key + "'" + (field.help.empty() ? "" : " (" + field.help + ")"));
      return;
    }
    read_value(child, where_, key, field, value);
  }
  void refuse_unknown() const;

 private:
  const YAML::Node node_;
  std::string where_, prefix_;
  std::vector<std::string> known_;
};

template <class T>
void read_value(const YAML::Node& node, const std::string& where, const std::string& key, const Field& field,
                T& value) {
  if constexpr (IsOptional<T>::value) {
    if (node.IsNull()) {
      value.reset();
      return;
    }
    typename T::value_type inner{};
    read_value(node, where, key, field, inner);
    value = std::move(inner);
  } else if constexpr (Visitable<T>) {
    Reader reader(node, where, key);
    value.visit(reader);
    reader.refuse_unknown();
  } else if constexpr (IsVector<T>::value) {
    if (!node.IsSequence()) refuse(where, node, "'" + key + "' must be a list");
    value.clear();
    for (std::size_t i = 0; i < node.size(); ++i) {
      typename T::value_type element{};
      read_value(node[i], where, key + "[" + std::to_string(i) + "]", field, element);
      value.push_back(std::move(element));
    }
  } else if constexpr (IsMap<T>::value) {
    if (!node.IsMap()) refuse(where, node, "'" + key + "' must be a map");
    value.clear();
    for (const auto& entry : node) {
      const auto name = entry.first.as<std::string>();
      read_value(entry.second, where, key + "." + name, field, value[name]);
    }
  } else if constexpr (EigenVector<T>) {
    static_assert(T::ColsAtCompileTime == 1 && T::RowsAtCompileTime > 0);
    if (!node.IsSequence() || node.size() != static_cast<std::size_t>(T::RowsAtCompileTime)) {
      refuse(where, node, "'" + key + "' must be a list of " + std::to_string(T::RowsAtCompileTime) + " numbers");
    }
    for (int i = 0; i < T::RowsAtCompileTime; ++i) {
      value(i) = number(node[i], where, key + "[" + std::to_string(i) + "]", field);
    }
  } else if constexpr (std::is_enum_v<T>) {
    std::vector<std::string> known(EnumNames<T>::names.begin(), EnumNames<T>::names.end());
    const std::string text = node.IsScalar() ? node.Scalar() : "";
    for (std::size_t i = 0; i < known.size(); ++i) {
      if (known[i] == text) {
        value = static_cast<T>(i);
        return;
      }
    }
    refuse(where, node, "'" + key + "' is '" + text + "', expected one of " + joined(known));
  } else if constexpr (std::is_same_v<T, bool>) {
    if (!YAML::convert<bool>::decode(node, value)) refuse(where, node, "'" + key + "' must be true or false");
  } else if constexpr (std::is_integral_v<T>) {
    number(node, where, key, field);  // bounds
    if (!YAML::convert<T>::decode(node, value)) refuse(where, node, "'" + key + "' must be a whole number");
  } else if constexpr (std::is_same_v<T, double>) {
    value = number(node, where, key, field);
  } else if constexpr (std::is_same_v<T, std::string>) {
    if (!node.IsScalar()) refuse(where, node, "'" + key + "' must be text");
    value = node.Scalar();
    if (!field.choices.empty() && std::find(field.choices.begin(), field.choices.end(), value) == field.choices.end()) {
      refuse(where, node, "'" + key + "' is '" + value + "', expected one of " + joined(field.choices));
    }
  } else {
    static_assert(!sizeof(T), "no YAML form for this type");
  }
}

template <class T>
void write_value(YAML::Emitter& out, T& value);

struct Writer {
  YAML::Emitter& out;
  template <class T>
  void operator()(const char* name, T& value, const Field& = {}) {
    // What is not there has no key: a file without it says the same.
    if constexpr (IsOptional<T>::value) {
      if (!value) return;
    }
    out << YAML::Key << name << YAML::Value;
    write_value(out, value);
  }
};

template <class T>
void write_value(YAML::Emitter& out, T& value) {
  if constexpr (IsOptional<T>::value) {
    if (value) {
      write_value(out, *value);
    } else {
      out << YAML::Null;
    }
  } else if constexpr (Visitable<T>) {
    out << YAML::BeginMap;
    Writer writer{out};
    value.visit(writer);
    out << YAML::EndMap;
  } else if constexpr (IsVector<T>::value) {
    constexpr bool flow =
        std::is_arithmetic_v<typename T::value_type> || std::is_same_v<typename T::value_type, std::string>;
    if (flow || value.empty()) out << YAML::Flow;
    out << YAML::BeginSeq;
    for (auto&& element : value) {
      auto copy = element;
      write_value(out, copy);
    }
    out << YAML::EndSeq;
  } else if constexpr (IsMap<T>::value) {
    out << YAML::BeginMap;
    for (auto& [name, element] : value) {
      out << YAML::Key << name << YAML::Value;
      write_value(out, element);
    }
    out << YAML::EndMap;
  } else if constexpr (EigenVector<T>) {
    out << YAML::Flow << YAML::BeginSeq;
    for (int i = 0; i < T::RowsAtCompileTime; ++i) out << format(value(i));
    out << YAML::EndSeq;
  } else if constexpr (std::is_enum_v<T>) {
    out << enum_name(value);
  } else if constexpr (std::is_same_v<T, double>) {
    out << format(value);
  } else {
    out << value;
  }
}

struct Describer {
  std::string prefix;
  std::string& text;
  void line(const std::string& key, const std::string& value, const Field& field) const;
  template <class T>
  void operator()(const char* name, T& value, const Field& field = {}) {
    const std::string key = prefix.empty() ? name : prefix + "." + name;
    if constexpr (Visitable<T>) {
      Describer inner{key, text};
      value.visit(inner);
    } else {
      YAML::Emitter out;
      out << YAML::Flow;
      write_value(out, value);
      Field shown = field;
      if constexpr (std::is_enum_v<T>) shown.choices.assign(EnumNames<T>::names.begin(), EnumNames<T>::names.end());
      line(key, out.c_str(), shown);
    }
  }
};

Result<YAML::Node> parse(const std::string& text, const std::string& where);

}  // namespace detail

/// Reads T from a parsed node. `where` names the file in errors. A T with `Status validate() const` is validated too.
template <Visitable T>
Result<T> read_node(const YAML::Node& node, const std::string& where) {
  T value{};
  try {
    detail::Reader reader(node, where, "");
    value.visit(reader);
    reader.refuse_unknown();
  } catch (const detail::Refused& refused) {
    return refused.error;
  } catch (const YAML::Exception& e) {
    return Error{Code::config, where + ":" + std::to_string(e.mark.line + 1) + ": " + e.msg};
  }
  if constexpr (requires {
                  { value.validate() } -> std::convertible_to<Status>;
                }) {
    if (auto status = value.validate(); !status.ok()) return status.error().at(where);
  }
  return value;
}

/// Reads T from YAML text.
template <Visitable T>
Result<T> read_text(const std::string& text, const std::string& where) {
  PRIMO_ASSIGN(const YAML::Node node, detail::parse(text, where));
  return read_node<T>(node, where);
}

/// Reads T from a YAML file.
template <Visitable T>
Result<T> read(const std::filesystem::path& path) {
  PRIMO_ASSIGN(const std::string text, read_file(path));
  return read_text<T>(text, path.string());
}

/// The effective configuration: every field with its value, as YAML that read_text() reads back to the same value.
template <Visitable T>
std::string dump(T value) {
  YAML::Emitter out;
  detail::write_value(out, value);
  return std::string(out.c_str()) + "\n";
}

/// A table of all fields: key, default, unit, bounds, sentence. For --help and the docs.
template <Visitable T>
std::string describe() {
  T value{};
  std::string text;
  detail::Describer describer{"", text};
  value.visit(describer);
  return text;
}

/// Applies "a.b.c=value" overrides to a parsed YAML map, e.g. from --set options.
Result<YAML::Node> override_keys(YAML::Node node, const std::vector<std::string>& assignments);

}  // namespace primo::config
