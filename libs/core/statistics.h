// Rates with their count and interval.
#pragma once

#include <cstdint>
#include <string>

namespace primo {

/// Successes out of trials, with Wilson's score interval.
struct Rate {
  std::int64_t successes = 0;
  std::int64_t trials = 0;

  void add(bool success) {
    successes += success;
    ++trials;
  }
  double value() const { return trials ? static_cast<double>(successes) / static_cast<double>(trials) : 0.0; }
  double lower(double z = kZ95) const;  ///< lower end of the Wilson interval; 0 without trials
  double upper(double z = kZ95) const;  ///< upper end; 1 without trials
  /// "0.83 (5/6, 95 % 0.44–0.97)"
  std::string text() const;

  static constexpr double kZ95 = 1.959963984540054;
};

}  // namespace primo
