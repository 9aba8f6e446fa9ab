// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause

/// What all linear solvers say of a system that has no one solution.
#pragma once

#include <Eigen/Core>

#include "cloud_colorizer/base/check.hpp"

namespace cloud_colorizer {

/// Relative to the matrix, below it a pivot or an eigenvalue is rounding error. Well conditioned systems have far
/// larger ones.
constexpr double kSingular = 1e-13;

/// Throws std::runtime_error unless `regular`.
inline void requireRegular(bool regular, Eigen::Index size, const char* what) {
  require(regular, "the system of ", size, " points is ", what,
          ": a part of the graph has no anchor, or a weight is negative");
}

}  // namespace cloud_colorizer
