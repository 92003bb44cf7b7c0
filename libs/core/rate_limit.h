// Not more often than so many times a second.
#pragma once

#include <chrono>
#include <optional>

namespace primo {

/// One thread at a time.
class RateLimit {
 public:
  using Clock = std::chrono::steady_clock;
  /// hz: 0 means never; finite and not negative.
  explicit RateLimit(double hz) : hz_(hz) {}
  /// Whether it may happen now; then it has happened.
  bool due(Clock::time_point now = Clock::now()) {
    if (!(hz_ > 0)) return false;
    if (last_ && std::chrono::duration<double>(now - *last_).count() * hz_ < 1) return false;
    last_ = now;
    return true;
  }

 private:
  double hz_;
  std::optional<Clock::time_point> last_;
};

}  // namespace primo
