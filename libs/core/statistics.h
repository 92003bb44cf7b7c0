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

/// Two methods tried on the same cases: how often both, one alone or neither succeeded.
struct Paired {
  std::int64_t both = 0, first_only = 0, second_only = 0, neither = 0;

  void add(bool first, bool second) { ++(first ? second ? both : first_only : second ? second_only : neither); }
  std::int64_t trials() const { return both + first_only + second_only + neither; }
  Rate first() const { return {both + first_only, trials()}; }
  Rate second() const { return {both + second_only, trials()}; }
  /// Rate of the second less that of the first; 0 without trials.
  double difference() const;
  /// Newcombe's hybrid score interval of the difference (Statistics in Medicine 17, 1998, method 10): −1 and 1 without
  /// trials.
  double lower(double z = Rate::kZ95) const;
  double upper(double z = Rate::kZ95) const;
  /// McNemar's exact test, two-sided: how probable it is that the cases in which one alone succeeded are split at least
  /// so unevenly when neither method is better. 1 without such cases.
  double p_value() const;
  /// The smallest difference of rates that McNemar's test at 5 % would find with the given power in as many cases,
  /// where one method alone succeeds as often as here (Connor, Biometrics 43, 1987). 1 when there is none.
  double detectable(double power = 0.8) const;

  bool operator==(const Paired&) const = default;
};

}  // namespace primo
