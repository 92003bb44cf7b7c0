// What the benchmarks measure by.
#pragma once

#include <sys/resource.h>

#include <algorithm>
#include <cmath>
#include <ctime>
#include <nlohmann/json.hpp>
#include <utility>
#include <vector>

#include "core/statistics.h"

namespace primo::bench {

/// CPU time of this thread.
inline double cpu_seconds() {
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}
inline double cpu_milliseconds() { return 1e3 * cpu_seconds(); }

/// The nearest value; 0 of none.
inline double quantile(std::vector<double> values, double fraction) {
  if (values.empty()) return 0;
  std::sort(values.begin(), values.end());
  return values[static_cast<std::size_t>(std::lround(fraction * static_cast<double>(values.size() - 1)))];
}
inline double median(std::vector<double> values) { return quantile(std::move(values), 0.5); }

/// Of this process until now, MiB.
inline double peak_memory() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return static_cast<double>(usage.ru_maxrss) / 1024;
}

/// A rate with its count and 95 % interval.
inline nlohmann::ordered_json json_of(const Rate& rate) {
  return {{"rate", rate.value()},
          {"successes", rate.successes},
          {"trials", rate.trials},
          {"lower", rate.lower()},
          {"upper", rate.upper()}};
}

}  // namespace primo::bench
