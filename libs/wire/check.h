// Checks of what came over the wire.
#pragma once

#include <cmath>
#include <cstdint>
#include <limits>
#include <string>
#include <vector>

#include "config/config.h"
#include "core/result.h"

namespace primo::wire {

/// Bounds of sequences and texts: far above what is used, far below what could exhaust a process.
inline constexpr std::size_t kMaxText = 65536;
inline constexpr std::size_t kMaxItems = 100000;        ///< objects, tasks, literals, …
inline constexpr std::size_t kMaxNumbers = 20'000'000;  ///< points, matrix entries, bytes

inline Error malformed(const std::string& field, const std::string& what) {
  return {Code::data, "malformed message: " + field + " " + what};
}

inline Status check_count(const std::string& field, std::size_t count, std::size_t most = kMaxItems) {
  if (count <= most) return success();
  return malformed(field,
                   "has " + std::to_string(count) + " entries, at most " + std::to_string(most) + " are allowed");
}

inline Status check_text(const std::string& field, const std::string& text) {
  if (text.size() <= kMaxText) return success();
  return malformed(
      field, "has " + std::to_string(text.size()) + " bytes, at most " + std::to_string(kMaxText) + " are allowed");
}

inline Status check_texts(const std::string& field, const std::vector<std::string>& texts) {
  PRIMO_TRY(check_count(field, texts.size()));
  for (const std::string& text : texts) PRIMO_TRY(check_text(field, text));
  return success();
}

inline Status check_finite(const std::string& field, double value) {
  if (std::isfinite(value)) return success();
  return malformed(field, "is " + std::to_string(value) + ", expected a finite number");
}

template <class T>
Status check_finite(const std::string& field, const std::vector<T>& values) {
  PRIMO_TRY(check_count(field, values.size(), kMaxNumbers));
  bool finite = true;  // all at once, as the sequences are long and hardly ever wrong
  for (const T value : values) finite &= std::abs(value) <= std::numeric_limits<T>::max();
  if (finite) return success();
  for (const T value : values) PRIMO_TRY(check_finite(field, static_cast<double>(value)));
  return success();
}

template <class E>
Result<E> enum_from(const std::string& field, std::uint8_t value) {
  constexpr std::size_t count = config::EnumNames<E>::names.size();
  if (value < count) return static_cast<E>(value);
  return malformed(field, "is " + std::to_string(value) + ", expected less than " + std::to_string(count));
}

/// Visits a struct's fields and holds each against the bounds that its own list of fields states, as reading a file
/// does.
class FieldChecker {
 public:
  explicit FieldChecker(std::string prefix) : prefix_(std::move(prefix)) {}

  template <class T>
  void operator()(const char* name, T& value, const config::Field& field = {}) {
    check(prefix_ + "." + name, value, field);
  }
  const Status& status() const { return status_; }

 private:
  void fail(Error error) {
    if (status_.ok()) status_ = std::move(error);
  }
  void number(const std::string& key, double value, const config::Field& field) {
    if (!std::isfinite(value) || value < field.min || value > field.max) {
      fail(malformed(key, "is " + std::to_string(value) + ", expected " + config::detail::format(field.min) + " to " +
                              config::detail::format(field.max)));
    }
  }
  template <class T>
  void check(const std::string& key, T& value, const config::Field& field) {
    if (!status_.ok()) return;
    if constexpr (config::detail::IsOptional<T>::value) {
      if (value) check(key, *value, field);
    } else if constexpr (config::Visitable<T>) {
      FieldChecker inner(key);
      value.visit(inner);
      if (!inner.status().ok()) fail(inner.status().error());
    } else if constexpr (config::detail::IsVector<T>::value) {
      if (value.size() > kMaxItems) return fail(check_count(key, value.size()).error());
      for (std::size_t i = 0; i < value.size(); ++i) check(key + "[" + std::to_string(i) + "]", value[i], field);
    } else if constexpr (config::detail::IsMap<T>::value) {
      for (auto& [name, element] : value) check(key + "." + name, element, field);
    } else if constexpr (config::EigenVector<T>) {
      for (int i = 0; i < T::RowsAtCompileTime; ++i) number(key, value(i), field);
    } else if constexpr (std::is_same_v<T, std::string>) {
      if (value.size() > kMaxText) return fail(check_text(key, value).error());
      const auto& choices = field.choices;
      if (!choices.empty() && std::find(choices.begin(), choices.end(), value) == choices.end()) {
        fail(malformed(key, "is '" + value + "', expected one of " + config::detail::joined(choices)));
      }
    } else if constexpr (std::is_arithmetic_v<T> && !std::is_same_v<T, bool>) {
      number(key, static_cast<double>(value), field);
    }
    // Enums are checked where they are made of a number.
  }

  std::string prefix_;
  Status status_ = success();
};

template <class T>
Status check_fields(const std::string& name, T& value) {
  FieldChecker checker(name);
  value.visit(checker);
  return checker.status();
}

}  // namespace primo::wire
