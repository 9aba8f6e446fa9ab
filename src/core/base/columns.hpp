// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause

/// Picking columns by number. (Eigen 3.4 can do it with `matrix(Eigen::all, indices)`; Ubuntu 20.04 has 3.3.7.)
#pragma once

#include <Eigen/Core>
#include <vector>

namespace cloud_colorizer {

/// The columns `indices` of a matrix, or the elements of a vector.
template <class Matrix>
Matrix gatherColumns(const Matrix& matrix, const std::vector<Eigen::Index>& indices) {
  const auto count = static_cast<Eigen::Index>(indices.size());
  if constexpr (Matrix::ColsAtCompileTime == 1) {
    Matrix picked(count);
    for (Eigen::Index k = 0; k < count; ++k) picked[k] = matrix[indices[static_cast<std::size_t>(k)]];
    return picked;
  } else {
    Matrix picked(matrix.rows(), count);
    for (Eigen::Index k = 0; k < count; ++k) picked.col(k) = matrix.col(indices[static_cast<std::size_t>(k)]);
    return picked;
  }
}

}  // namespace cloud_colorizer
