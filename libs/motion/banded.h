// Symmetric positive definite band matrices.
#pragma once

#include <Eigen/Core>

namespace primo::motion {

/// The lower band of a symmetric matrix A: column j holds A(j, j), A(j+1, j), …, A(j+w, j).
class BandMatrix {
 public:
  /// N × N with w sub-diagonals, zero.
  BandMatrix(int size, int width) : band_(Eigen::MatrixXd::Zero(width + 1, size)) {}
  int size() const { return static_cast<int>(band_.cols()); }
  int width() const { return static_cast<int>(band_.rows()) - 1; }
  /// A(row, column) for column ≤ row ≤ column + w.
  double& at(int row, int column) { return band_(row - column, column); }
  double at(int row, int column) const { return band_(row - column, column); }

  /// A ← L with A = L Lᵀ, in place, O(N w²). False when A is not positive definite or not finite; A is then spoilt.
  bool factorise();
  /// x ← A⁻¹ x after factorise().
  void solve(Eigen::VectorXd& x) const;

 private:
  Eigen::MatrixXd band_;
};

}  // namespace primo::motion
