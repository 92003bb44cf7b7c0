// Counter-based random numbers: Philox4x32-10 (Salmon et al., Parallel Random Numbers: As Easy as 1, 2, 3, SC 2011).
// A stream is a value: (seed, purpose, indices) names it, so any process can draw the same numbers in any order.
#pragma once

#include <array>
#include <cstdint>
#include <initializer_list>
#include <string_view>

namespace primo {

/// One Philox4x32-10 block: 128 bits from a 128-bit counter and a 64-bit key.
std::array<std::uint32_t, 4> philox4x32(std::array<std::uint32_t, 4> counter, std::array<std::uint32_t, 2> key);

class Random {
 public:
  /// The stream of this seed, purpose ("jiggle", "cma", …) and indices (restart, generation, candidate, …).
  Random(std::uint64_t seed, std::string_view purpose, std::initializer_list<std::uint64_t> indices = {});

  std::uint64_t bits();  ///< 64 uniform bits
  double uniform();      ///< in [0, 1), 53 bits
  double uniform(double lo, double hi) { return lo + (hi - lo) * uniform(); }
  double normal();                       ///< standard normal, Box–Muller
  std::uint64_t below(std::uint64_t n);  ///< uniform in 0 … n−1, n ≥ 1, unbiased

 private:
  std::array<std::uint32_t, 2> key_;
  std::uint64_t stream_;
  std::uint64_t block_ = 0;
  std::array<std::uint32_t, 4> buffer_{};
  int used_ = 4;
  bool has_spare_ = false;
  double spare_ = 0;
};

}  // namespace primo
