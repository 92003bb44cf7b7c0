// Symmetric positive definite band matrices.
#pragma once

#include <Eigen/Core>

namespace primo::motion {

/// The lower band of a symmetric matrix A: column j holds A(j, j), A(j+1, j), …, A(j+w, j).
class BandMatrix {
 public:
  /// Columns that factorise() takes at once. Each column is followed by 2 kPanel − 1 zeros, so that those of a panel
  /// end at the same row and in whole panels.
  static constexpr int kPanel = 4;

  /// N × N with w sub-diagonals, zero.
  BandMatrix(int size, int width)
      : width_(width), band_(Eigen::MatrixXd::Zero(width + 2 * kPanel, size)), inverse_(size) {}
  int size() const { return static_cast<int>(band_.cols()); }
  int width() const { return width_; }
  /// A(row, column) for column ≤ row ≤ column + w.
  double& at(int row, int column) { return band_(row - column, column); }
  double at(int row, int column) const { return band_(row - column, column); }

  /// A ← L with A = L Lᵀ, in place, O(N w²). False when A is not positive definite or not finite; A is then spoilt.
  /// The same bits whatever instructions the processor has.
  bool factorise();
  /// x ← A⁻¹ x after factorise().
  void solve(Eigen::VectorXd& x) const;

 private:
  int width_;
  Eigen::MatrixXd band_;
  Eigen::VectorXd inverse_;  // of L's diagonal
};

}  // namespace primo::motion
