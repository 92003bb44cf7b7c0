#include "motion/banded.h"

#include <algorithm>
#include <cmath>

namespace primo::motion {

bool BandMatrix::factorise() {
  const int n = size(), w = width(), stride = w + 1;
  double* const band = band_.data();
  for (int j = 0; j < n; ++j) {
    double* const column = band + static_cast<std::ptrdiff_t>(j) * stride;
    const double pivot = column[0];
    if (!(pivot > 0) || !std::isfinite(pivot)) return false;
    const double root = std::sqrt(pivot), inverse = 1 / root;
    if (!std::isfinite(inverse)) return false;
    column[0] = root;
    const int below = std::min(w, n - 1 - j);
    for (int i = 1; i <= below; ++i) column[i] *= inverse;
    // Right-looking: take this column's outer product from the triangle to its right.
    for (int i = 1; i <= below; ++i) {
      const double factor = column[i];
      if (factor == 0) continue;
      double* const target = column + static_cast<std::ptrdiff_t>(i) * stride;
      for (int k = 0; k <= below - i; ++k) target[k] -= factor * column[i + k];
    }
  }
  return true;
}

void BandMatrix::solve(Eigen::VectorXd& x) const {
  const int n = size(), w = width(), stride = w + 1;
  double* const values = x.data();
  for (int j = 0; j < n; ++j) {
    const double* const column = band_.data() + static_cast<std::ptrdiff_t>(j) * stride;
    const double value = values[j] /= column[0];
    const int below = std::min(w, n - 1 - j);
    for (int i = 1; i <= below; ++i) values[j + i] -= value * column[i];
  }
  for (int j = n - 1; j >= 0; --j) {
    const double* const column = band_.data() + static_cast<std::ptrdiff_t>(j) * stride;
    const int below = std::min(w, n - 1 - j);
    // Two sums: a single one would wait for each addition.
    double even = 0, odd = 0;
    int i = 1;
    for (; i + 1 <= below; i += 2) {
      even += column[i] * values[j + i];
      odd += column[i + 1] * values[j + i + 1];
    }
    if (i <= below) even += column[i] * values[j + i];
    values[j] = (values[j] - (even + odd)) / column[0];
  }
}

}  // namespace primo::motion
