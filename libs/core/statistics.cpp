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

}  // namespace

double Rate::lower(double z) const { return trials ? wilson(*this, z, -1) : 0.0; }
double Rate::upper(double z) const { return trials ? wilson(*this, z, 1) : 1.0; }

std::string Rate::text() const {
  char buffer[96];
  std::snprintf(buffer, sizeof buffer, "%.2f (%lld/%lld, 95 %% %.2f–%.2f)", value(), static_cast<long long>(successes),
                static_cast<long long>(trials), lower(), upper());
  return buffer;
}

}  // namespace primo
