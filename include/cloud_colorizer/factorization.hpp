// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause

/// Sparse factorisation by SuiteSparse, which nobody else sees.
#pragma once

#include <Eigen/SparseCore>
#include <memory>
#include <vector>

namespace cloud_colorizer {

enum class SolverKind { kCholmod, kSpqr };

/// The constructor is the factorisation of a symmetric positive definite matrix, of which only the lower triangle is
/// read (and which must be compressed, with sorted rows, as assembleSystem makes it). Indices are 32-bit: at most 2^31
/// - 1 entries in the matrix; for kCholmod also in the factor. Throws std::runtime_error, with the reason, on a
/// singular or indefinite matrix (reciprocal condition below about 1e-13), when out of memory, and beyond the limit.
/// Different objects may be used from different threads; one object by one thread at a time, also in solve().
class Factorization {
 public:
  /// `elimination_order` (every index once, as OrderedGraph has it) saves CHOLMOD its search for an ordering; empty:
  /// AMD. It does not change the result beyond rounding. SuiteSparseQR always finds its own.
  Factorization(const Eigen::SparseMatrix<double>& lower, SolverKind solver,
                const std::vector<int>& elimination_order = {});
  ~Factorization();
  Factorization(Factorization&&) noexcept;
  Factorization& operator=(Factorization&&) noexcept;

  /// X of A X = rhs, n x m for any m. Throws std::invalid_argument for another number of rows.
  Eigen::MatrixXd solve(const Eigen::MatrixXd& rhs) const;

  struct Impl;

 private:
  std::unique_ptr<Impl> impl_;
};

}  // namespace cloud_colorizer
