#include "motion/banded.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

namespace primo::motion {
namespace {

// Compiled twice, for processors with and without AVX2. Each element goes through the same operations in the same order
// in both (no fused multiply-add), so that results do not depend on the processor.
#if defined(__x86_64__)
#define PRIMO_AVX2 [[gnu::target("avx2")]]
bool has_avx2() {
  static const bool has = __builtin_cpu_supports("avx2");
  return has;
}
#endif

constexpr int kPanel = BandMatrix::kPanel;
using Four [[gnu::vector_size(32), gnu::aligned(8), gnu::may_alias]] = double;

using Columns = std::array<const double*, kPanel>;

/// A panel's columns from the row after the panel on.
[[gnu::always_inline]] inline Columns below_panel(const double* band, std::ptrdiff_t stride, int begin) {
  Columns c{};
  for (int p = 0; p < kPanel; ++p) c[static_cast<std::size_t>(p)] = band + (begin + p) * stride + kPanel - p;
  return c;
}

/// Takes the outer product of a panel's four columns of L from the columns to its right: the target's entry (k, r), r ≤
/// k < count, loses Σ_p c_p[r] c_p[k], in one pass over the target. Runs over count by up to three entries, where the
/// columns are zero.
[[gnu::always_inline]] inline void take_panel(const Columns& c, double* target, std::ptrdiff_t stride, int count) {
  for (int r = 0; r < count; ++r, target += stride) {
    const double f0 = c[0][r], f1 = c[1][r], f2 = c[2][r], f3 = c[3][r];
    for (int k = r; k < count; k += 4) {
      Four& entries = *reinterpret_cast<Four*>(target + (k - r));
      const auto at = [&](int p) -> const Four& {
        return *reinterpret_cast<const Four*>(c[static_cast<std::size_t>(p)] + k);
      };
      entries = (((entries - f0 * at(0)) - f1 * at(1)) - f2 * at(2)) - f3 * at(3);
    }
  }
}

[[gnu::always_inline]] inline bool cholesky(double* band, double* inverses, std::ptrdiff_t stride, int w, int n) {
  for (int begin = 0; begin < n; begin += kPanel) {
    const int end = std::min(n, begin + kPanel);
    for (int j = begin; j < end; ++j) {
      double* const column = band + j * stride;
      const double pivot = column[0];
      if (!(pivot > 0) || !std::isfinite(pivot)) return false;
      const double root = std::sqrt(pivot), inverse = 1 / root;
      if (!std::isfinite(inverse)) return false;
      column[0] = root;
      inverses[j] = inverse;
      const int below = std::min(w, n - 1 - j);
      for (int i = 1; i <= below; ++i) column[i] *= inverse;
      // Right-looking within the panel.
      for (int i = 1; i <= std::min(below, end - 1 - j); ++i) {
        double* __restrict target = column + i * stride;
        const double* __restrict source = column + i;
        const double factor = column[i];
        for (int k = 0; k <= below - i; ++k) target[k] -= factor * source[k];
      }
    }
    const int count = std::min(w, n - end);
    if (count <= 0) continue;
    take_panel(below_panel(band, stride, begin), band + end * stride, stride, count);
  }
  return true;
}

/// L y = x, then Lᵀ x = y, in place, a panel of columns at a time; `inverse` has the inverses of L's diagonal.
[[gnu::always_inline]] inline void substitute(const double* band, const double* inverse, std::ptrdiff_t stride, int w,
                                              int n, double* x) {
  const auto entry = [&](int row, int column) { return band[column * stride + row - column]; };
  const int panels = n / kPanel * kPanel;
  for (int j = 0; j < panels; j += kPanel) {
    double* const y = x + j;
    for (int p = 0; p < kPanel; ++p) {
      for (int q = 0; q < p; ++q) y[p] -= entry(j + p, j + q) * y[q];
      y[p] *= inverse[j + p];
    }
    const Columns c = below_panel(band, stride, j);
    const double y0 = y[0], y1 = y[1], y2 = y[2], y3 = y[3];
    double* __restrict rest = y + kPanel;
    for (int k = 0; k < std::min(w, n - j - kPanel); ++k)
      rest[k] = (((rest[k] - c[0][k] * y0) - c[1][k] * y1) - c[2][k] * y2) - c[3][k] * y3;
  }
  for (int j = panels; j < n; ++j) {
    x[j] *= inverse[j];
    for (int i = j + 1; i < std::min(n, j + w + 1); ++i) x[i] -= entry(i, j) * x[j];
  }
  for (int j = n - 1; j >= panels; --j) {
    for (int i = j + 1; i < std::min(n, j + w + 1); ++i) x[j] -= entry(i, j) * x[i];
    x[j] *= inverse[j];
  }
  for (int j = panels - kPanel; j >= 0; j -= kPanel) {
    const Columns c = below_panel(band, stride, j);
    const double* const rest = x + j + kPanel;
    std::array<double, kPanel> sum{};
    for (int k = 0; k < std::min(w, n - j - kPanel); ++k) {
      for (std::size_t p = 0; p < kPanel; ++p) sum[p] += c[p][k] * rest[k];
    }
    for (int p = kPanel - 1; p >= 0; --p) {
      x[j + p] -= sum[static_cast<std::size_t>(p)];
      for (int q = p + 1; q < kPanel; ++q) x[j + p] -= entry(j + q, j + p) * x[j + q];
      x[j + p] *= inverse[j + p];
    }
  }
}

#if defined(__x86_64__)
PRIMO_AVX2 bool cholesky_avx2(double* band, double* inverses, std::ptrdiff_t stride, int w, int n) {
  return cholesky(band, inverses, stride, w, n);
}
PRIMO_AVX2 void substitute_avx2(const double* band, const double* inverse, std::ptrdiff_t stride, int w, int n,
                                double* x) {
  substitute(band, inverse, stride, w, n, x);
}
#endif

}  // namespace

bool BandMatrix::factorise() {
#if defined(__x86_64__)
  if (has_avx2()) return cholesky_avx2(band_.data(), inverse_.data(), band_.rows(), width(), size());
#endif
  return cholesky(band_.data(), inverse_.data(), band_.rows(), width(), size());
}

void BandMatrix::solve(Eigen::VectorXd& x) const {
#if defined(__x86_64__)
  if (has_avx2()) return substitute_avx2(band_.data(), inverse_.data(), band_.rows(), width(), size(), x.data());
#endif
  substitute(band_.data(), inverse_.data(), band_.rows(), width(), size(), x.data());
}

}  // namespace primo::motion
