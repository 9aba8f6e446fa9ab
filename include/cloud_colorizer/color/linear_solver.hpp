// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause

/// Solvers of sparse symmetric positive definite systems; SuiteSparse, which nobody else sees, is behind the direct
/// ones.
#pragma once

#include <Eigen/SparseCore>
#include <memory>
#include <vector>

namespace cloud_colorizer {

/// kConjugateGradients suits any graph whose anchors are spread over it, and bounds the memory by the number of edges.
/// kCholmod is exact, and as fast where an elimination order is known (shared grids). kSpqr is the paper's.
enum class SolverKind { kConjugateGradients, kCholmod, kSpqr };

/// The constructor prepares (the direct solvers factor) a symmetric positive definite matrix, of which only the lower
/// triangle is read (and which must be compressed, with sorted rows, as assembleSystem makes it). Indices are 32-bit:
/// at most 2^31 - 1 entries in the matrix; for kCholmod also in the factor. Throws std::runtime_error, with the reason,
/// on a singular or indefinite matrix (reciprocal condition below about 1e-13; kConjugateGradients finds it in
/// solve()), when out of memory, and beyond the limit. Different objects may be used from different threads; one object
/// by one thread at a time, also in solve().
class LinearSolver {
 public:
  /// `elimination_order` (every index once, as OrderedGraph has it) saves CHOLMOD its search for an ordering; empty:
  /// AMD. It does not change the result beyond rounding. SuiteSparseQR always finds its own.
  LinearSolver(const Eigen::SparseMatrix<double>& lower, SolverKind solver,
               const std::vector<int>& elimination_order = {});
  ~LinearSolver();
  LinearSolver(LinearSolver&&) noexcept;
  LinearSolver& operator=(LinearSolver&&) noexcept;

  /// X of A X = rhs, n x m for any m. `guess`, n x m or empty for zeros, is where kConjugateGradients starts. Throws
  /// std::invalid_argument for another size, std::runtime_error if it does not converge.
  Eigen::MatrixXd solve(const Eigen::MatrixXd& rhs, const Eigen::MatrixXd& guess = Eigen::MatrixXd()) const;

  struct Impl;

 private:
  std::unique_ptr<Impl> impl_;
};

}  // namespace cloud_colorizer
