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
  const int n = size(), w = width();
  for (int j = 0; j < n; ++j) {
    x[j] /= band_(0, j);
    const int below = std::min(w, n - 1 - j);
    x.segment(j + 1, below) -= x[j] * band_.col(j).segment(1, below);
  }
  for (int j = n - 1; j >= 0; --j) {
    const int below = std::min(w, n - 1 - j);
    x[j] = (x[j] - band_.col(j).segment(1, below).dot(x.segment(j + 1, below))) / band_(0, j);
  }
}

}  // namespace primo::motion
