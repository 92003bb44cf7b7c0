// The rates that the paper gives (Orthey, Toussaint, Jetchev, ICRA 2013), to stand beside those measured.
#pragma once

#include <array>
#include <optional>
#include <string_view>

namespace primo::study {

struct PublishedRate {
  std::string_view action;
  double displacement = 0;       ///< m
  std::optional<double> before;  ///< of the hand-tuned primitive P; not given for placing
  double after = 0;              ///< of the optimized primitive P*
  std::string_view source;
};

inline constexpr std::array<PublishedRate, 4> kPublishedRates = {{{"grasp", 0, 0.3, 1.0, "Table I"},
                                                                  {"grasp", 0.015, 0.3, 0.94, "Table I"},
                                                                  {"place", 0, {}, 1.0, "Table II"},
                                                                  {"place", 0.015, {}, 0.92, "Table II"}}};

/// The paper's rate for this action and displacement, if it has one.
inline std::optional<PublishedRate> published_rate(std::string_view action, double displacement) {
  for (const auto& rate : kPublishedRates) {
    if (rate.action == action && rate.displacement == displacement) return rate;
  }
  return std::nullopt;
}

}  // namespace primo::study
