// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause

/// Conjugate gradients for graphs that no elimination order suits.
#pragma once

#include <Eigen/SparseCore>
#include <vector>

namespace cloud_colorizer {

/// Solves A X = B by conjugate gradients, preconditioned by a symmetric Gauss-Seidel sweep in Eisenstat's form: S. C.
/// Eisenstat, "Efficient implementation of a class of preconditioned conjugate gradient methods", SIAM J. Sci. Stat.
/// Comput. 2, 1981. An iteration costs as much as one without a preconditioner, and less than half as many are needed:
/// about 20, whatever the number of points is, for with anchors all over the graph what one point says is soon
/// forgotten. Four columns go side by side, so A is read once for the channels of a colour. Eigen's ConjugateGradient
/// with its IncompleteCholesky takes three times as long.
class ConjugateGradients {
 public:
  /// `lower` is the lower triangle of A, compressed, every column's first entry its diagonal. Throws std::runtime_error
  /// unless the diagonal is positive.
  explicit ConjugateGradients(const Eigen::SparseMatrix<double>& lower);

  /// n x m. Starts from `guess`, n x m. Ends when the error is about 1e-5 of the solution (root mean square), told by
  /// the residual and the smallest eigenvalue, which the iteration finds. Throws std::runtime_error where A turns out
  /// to be singular or indefinite, and without convergence.
  Eigen::MatrixXd solve(const Eigen::MatrixXd& rhs, const Eigen::MatrixXd& guess) const;

 private:
  static constexpr int kLanes = 4;
  using LaneRows = Eigen::Array<double, Eigen::Dynamic, kLanes, Eigen::RowMajor>;
  using Lanes = Eigen::Array<double, 1, kLanes>;

  void toResidual(const LaneRows& solution, LaneRows& rhs) const;
  Lanes step(const Lanes& beta, const LaneRows& residual, LaneRows& direction, LaneRows& backward,
             LaneRows& image) const;
  void solveLanes(LaneRows& residual, LaneRows& solution) const;
  double constantQuotient() const;

  Eigen::Index size_;
  std::vector<double> scale_;  ///< 1 / sqrt of the diagonal: A is used as 1 + L + L'
  std::vector<int> offsets_, rows_;
  std::vector<double> values_;  ///< of L, column by column
  double constant_quotient_ = 1;
};

}  // namespace cloud_colorizer
