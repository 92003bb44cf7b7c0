#include "motion/quadratic.h"

#include <algorithm>
#include <cmath>

namespace primo::motion {

void Quadratic::extend(const Quadratic& first) {
  const int k = first.variables();
  a_.topLeftCorner(k, k) = first.a_.topLeftCorner(k, k);
  a_.bottomRows(a_.rows() - k).setZero();
  gradient(0, k) = first.gradient(0, k);
}

void Quadratic::pin(int from, int count) {
  a_.middleRows(from, count).setZero();
  a_.middleCols(from, count).setZero();
  a_.diagonal().segment(from, count).setOnes();
}

bool Quadratic::eliminate(int k) {
  const auto last = a_.rows() - 1;
  for (Eigen::Index c = 0; c < last; ++c) {
    const auto below = a_.rows() - c;
    auto column = a_.col(c).tail(below);
    // Left-looking, four columns at a time: each entry is then loaded and stored a quarter as often.
    const auto before = std::min<Eigen::Index>(c, k);
    Eigen::Index j = 0;
    for (; j + 4 <= before; j += 4) {
      // The couplings of controls are diagonal, which leaves zeros.
      const double f0 = a_(c, j), f1 = a_(c, j + 1), f2 = a_(c, j + 2), f3 = a_(c, j + 3);
      if (f0 == 0 && f1 == 0 && f2 == 0 && f3 == 0) continue;
      column -= (f0 * a_.col(j).tail(below) + f1 * a_.col(j + 1).tail(below)) +
                (f2 * a_.col(j + 2).tail(below) + f3 * a_.col(j + 3).tail(below));
    }
    for (; j < before; ++j) column -= a_(c, j) * a_.col(j).tail(below);
    if (c >= k) continue;
    const double pivot = column[0];
    if (!(pivot > 0) || !std::isfinite(pivot)) return false;
    const double root = std::sqrt(pivot), inverse = 1 / root;
    if (!std::isfinite(inverse)) return false;
    column *= inverse;
    column[0] = root;
  }
  return true;
}

void minimiser(const Eigen::Ref<const Eigen::MatrixXd>& factor, Eigen::VectorXd& x) {
  const auto m = factor.rows() - 1, k = factor.cols();
  for (auto j = k - 1; j >= 0; --j) {
    const auto others = m - 1 - j;
    x[j] = -(factor(m, j) + factor.col(j).segment(j + 1, others).dot(x.segment(j + 1, others))) / factor(j, j);
  }
}

}  // namespace primo::motion
