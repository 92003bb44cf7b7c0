// Expected failures as values: a Result holds either a T or an Error that says what, where and what would be right.
#pragma once

#include <string>
#include <utility>
#include <variant>

#include "core/check.h"

namespace primo {

/// Kinds of failure. The process exit codes follow from them (see exit_code()).
enum class Code {
  usage,        ///< wrong command line
  config,       ///< a file or a value in it is wrong
  data,         ///< data that arrived (a message, a journal, a log) is malformed
  unavailable,  ///< a needed service, port, segment or lock cannot be had
  failed,       ///< the work itself failed
  internal,     ///< a broken assumption of our own
};

/// The exit code of a process that ends with this failure: 64 usage, 78 configuration or data, 69 unavailable, 1
/// failed, 70 internal.
constexpr int exit_code(Code code) {
  switch (code) {
    case Code::usage:
      return 64;
    case Code::config:
    case Code::data:
      return 78;
    case Code::unavailable:
      return 69;
    case Code::failed:
      return 1;
    case Code::internal:
      return 70;
  }
  return 70;
}

struct Error {
  Code code = Code::failed;
  std::string message;  ///< what, where, and what would be right

  /// The same error with its place put in front: "place: message".
  Error at(const std::string& place) const { return {code, place + ": " + message}; }
};

/// Either a T or an Error. Reading the wrong side is a programmer's error and aborts.
template <class T>
class [[nodiscard]] Result {
 public:
  using value_type = T;
  Result(T value) : state_(std::in_place_index<0>, std::move(value)) {}
  Result(Error error) : state_(std::in_place_index<1>, std::move(error)) {}

  bool ok() const { return state_.index() == 0; }
  explicit operator bool() const { return ok(); }

  const T& value() const& {
    PRIMO_CHECK(ok(), error_message());
    return std::get<0>(state_);
  }
  T& value() & {
    PRIMO_CHECK(ok(), error_message());
    return std::get<0>(state_);
  }
  T&& value() && {
    PRIMO_CHECK(ok(), error_message());
    return std::get<0>(std::move(state_));
  }
  const T& operator*() const& { return value(); }
  T& operator*() & { return value(); }
  const T* operator->() const { return &value(); }
  T* operator->() { return &value(); }

  const Error& error() const {
    PRIMO_CHECK(!ok(), "error() of a Result that holds a value");
    return std::get<1>(state_);
  }

 private:
  std::string error_message() const { return ok() ? "" : std::get<1>(state_).message; }
  std::variant<T, Error> state_;
};

/// Success without a value, or an Error.
struct Unit {};
using Status = Result<Unit>;
inline Status success() { return Unit{}; }

}  // namespace primo

/// Returns the error of `expression` from the enclosing function, or goes on.
#define PRIMO_TRY(expression)                                                              \
  do {                                                                                     \
    if (auto primo_status = (expression); !primo_status.ok()) return primo_status.error(); \
  } while (false)

#define PRIMO_CONCAT_INNER(a, b) a##b
#define PRIMO_CONCAT(a, b) PRIMO_CONCAT_INNER(a, b)
/// Declares `target` from the value of `expression`, or returns its error from the enclosing function.
#define PRIMO_ASSIGN(target, expression) PRIMO_ASSIGN_IMPL(PRIMO_CONCAT(primo_result_, __LINE__), target, expression)
#define PRIMO_ASSIGN_IMPL(result, target, expression) \
  auto result = (expression);                         \
  if (!result.ok()) return result.error();            \
  target = std::move(result).value()
