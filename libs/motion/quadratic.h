// Quadratic functions f(x) = xᵀA x + 2 gᵀx + constant, from which variables are minimised out: the messages of
// approximate inference in information form (a Gaussian's precision A and −g = A · mean).
#pragma once

#include <Eigen/Core>

namespace primo::motion {

/// f over m variables as the lower triangle of [A g; gᵀ ·], so that g is carried along like one more row of A. What is
/// above the diagonal and the last corner mean nothing.
class Quadratic {
 public:
  explicit Quadratic(int variables) : a_(Eigen::MatrixXd::Zero(variables + 1, variables + 1)) {}
  int variables() const { return static_cast<int>(a_.rows()) - 1; }
  void clear() { a_.setZero(); }

  /// A's block of the variables from `row` by those from `column`, row ≥ column.
  auto block(int row, int column, int rows, int columns) { return a_.block(row, column, rows, columns); }
  auto block(int row, int column, int rows, int columns) const { return a_.block(row, column, rows, columns); }
  auto gradient(int from, int count) { return a_.row(variables()).segment(from, count); }
  auto gradient(int from, int count) const { return a_.row(variables()).segment(from, count); }

  /// Makes this the function `first` of the first variables, whatever the others are.
  void extend(const Quadratic& first);
  /// x_i = 0 for these variables from now on.
  void pin(int from, int count);

  /// Minimises the first k variables out by a partial Cholesky factorisation: the rest becomes
  /// (A_bb − A_ba A_aa⁻¹ A_ab, g_b − A_ba A_aa⁻¹ g_a). False when A_aa is not positive definite or not finite; f is
  /// then spoilt.
  bool eliminate(int k);
  /// The function of the other variables after eliminate(k) into `rest`, which has that many.
  void rest(int k, Quadratic& rest) const { rest.a_ = a_.bottomRightCorner(a_.rows() - k, a_.rows() - k); }
  /// The factor's first k columns, m + 1 high: what minimiser() needs.
  auto factor(int k) const { return a_.leftCols(k); }

 private:
  Eigen::MatrixXd a_;
};

/// The eliminated variables' minimiser for given others, from the factor of eliminate(k): fills the first k entries of
/// x (m) from the others.
void minimiser(const Eigen::Ref<const Eigen::MatrixXd>& factor, Eigen::VectorXd& x);

}  // namespace primo::motion
