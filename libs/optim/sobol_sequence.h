// Sobol's low-discrepancy sequence (Sobol, USSR Comput. Math. 7 (1967); in Gray code: Antonov and Saleev, 1979), with
// as many dimensions as asked. The primitive polynomials are computed, and so are the initial direction numbers: odd
// ones drawn at random until Sobol's property A holds, by which the first 2^d points have one in each of the 2^d
// orthants of the box.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

namespace primo::optim {

class SobolSequence {
 public:
  static constexpr int kBits = 32;
  explicit SobolSequence(int dimension);

  int dimension() const { return static_cast<int>(directions_.size()); }
  /// The coordinates of point n as integers below 2^32; the first point is 0.
  std::vector<std::uint32_t> point(std::uint32_t n) const;

 private:
  std::vector<std::array<std::uint32_t, kBits>> directions_;
};

}  // namespace primo::optim
