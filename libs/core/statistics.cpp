#include "core/statistics.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

namespace primo {
namespace {

// Wilson (1927): (p + z²/2n ± z √(p(1−p)/n + z²/4n²)) / (1 + z²/n)
double wilson(const Rate& rate, double z, double sign) {
  const double n = static_cast<double>(rate.trials);
  const double p = rate.value();
  const double centre = p + z * z / (2 * n);
  const double half = z * std::sqrt(p * (1 - p) / n + z * z / (4 * n * n));
  return std::clamp((centre + sign * half) / (1 + z * z / n), 0.0, 1.0);
}

/// ln of the binomial coefficient.
double log_choose(std::int64_t n, std::int64_t k) {
  return std::lgamma(static_cast<double>(n) + 1) - std::lgamma(static_cast<double>(k) + 1) -
         std::lgamma(static_cast<double>(n - k) + 1);
}

/// Newcombe's φ: the correlation of the two successes, its numerator corrected for continuity when positive.
double newcombe_phi(const Paired& pair) {
  const double a = static_cast<double>(pair.both), b = static_cast<double>(pair.first_only);
  const double c = static_cast<double>(pair.second_only), d = static_cast<double>(pair.neither);
  const double margins = (a + b) * (c + d) * (a + c) * (b + d);
  if (margins == 0) return 0;
  double numerator = a * d - b * c;
  if (numerator > 0) numerator = std::max(0.0, numerator - (a + b + c + d) / 2);
  return numerator / std::sqrt(margins);
}

double root_of_squares(double first, double second, double phi) {
  return std::sqrt(std::max(0.0, first * first - 2 * phi * first * second + second * second));
}

/// Upper quantile of the standard normal distribution, by bisection of its tail.
double normal_quantile(double p) {
  double low = -10, high = 10;
  for (int i = 0; i < 80; ++i) {
    const double middle = (low + high) / 2;
    (0.5 * std::erfc(-middle / std::sqrt(2.0)) < p ? low : high) = middle;
  }
  return (low + high) / 2;
}

}  // namespace

double Rate::lower(double z) const { return trials ? wilson(*this, z, -1) : 0.0; }
double Rate::upper(double z) const { return trials ? wilson(*this, z, 1) : 1.0; }

std::string Rate::text() const {
  char buffer[96];
  std::snprintf(buffer, sizeof buffer, "%.2f (%lld/%lld, 95 %% %.2f–%.2f)", value(), static_cast<long long>(successes),
                static_cast<long long>(trials), lower(), upper());
  return buffer;
}

double Paired::difference() const { return second().value() - first().value(); }

double Paired::lower(double z) const {
  if (trials() == 0) return -1;
  return difference() -
         root_of_squares(second().value() - second().lower(z), first().upper(z) - first().value(), newcombe_phi(*this));
}

double Paired::upper(double z) const {
  if (trials() == 0) return 1;
  return difference() +
         root_of_squares(second().upper(z) - second().value(), first().value() - first().lower(z), newcombe_phi(*this));
}

double Paired::p_value() const {
  const std::int64_t n = first_only + second_only, fewer = std::min(first_only, second_only);
  double tail = 0;
  for (std::int64_t k = 0; k <= fewer; ++k) {
    tail += std::exp(log_choose(n, k) - static_cast<double>(n) * std::log(2.0));
  }
  return std::min(1.0, 2 * tail);
}

double Paired::detectable(double power) const {
  const auto n = static_cast<double>(trials());
  const double discordant = n > 0 ? static_cast<double>(first_only + second_only) / n : 1;
  // With no discordant case at all, the share that could just have gone unseen.
  const double share = discordant > 0 ? discordant : Rate{0, trials()}.upper();
  const double z = normal_quantile(power);
  double low = 0, high = 1;
  const auto found = [&](double d) {
    const double apart = std::max(share, d);  // a difference d needs as many discordant cases at least
    return d * std::sqrt(n) >= Rate::kZ95 * std::sqrt(apart) + z * std::sqrt(std::max(0.0, apart - d * d));
  };
  if (!found(high)) return 1;
  for (int i = 0; i < 60; ++i) {
    const double middle = (low + high) / 2;
    (found(middle) ? high : low) = middle;
  }
  return high;
}

}  // namespace primo
