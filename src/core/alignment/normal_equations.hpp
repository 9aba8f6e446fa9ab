// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause

/// Normal equations of all views together, with the unknown values of the points eliminated.
///
/// Minimise over x_v (D numbers a view) and m_p (one a point):  sum_k w_k (y_k + J_k x_v(k) - m_p(k))^2.
/// For any x the best m_p is a weighted mean, so it drops out (variable projection) and what remains couples every
/// two views that share a point: H_vv' = sum_p (delta_vv' w_k - w_k w_k' / W_p) J_k' J_k'. So the views converge
/// together, in a few steps, whatever the length of the chain between them.
#pragma once

#include <Eigen/SparseCholesky>
#include <algorithm>
#include <optional>
#include <vector>

#include "alignment/tracks.hpp"
#include "base/parallel.hpp"

namespace cloud_colorizer::alignment {

/// What the equations are made of, one entry an observation; weight 0 leaves one out.
template <int D>
struct Equations {
  std::vector<float> values;                          ///< y
  std::vector<float> weights;                         ///< w
  std::vector<Eigen::Matrix<float, D, 1>> jacobians;  ///< J
};

/// Weighted mean of the values of every point; 0 where all weights are.
template <int D>
Eigen::VectorXd pointMeans(const Tracks& tracks, const Equations<D>& equations) {
  Eigen::VectorXd means = Eigen::VectorXd::Zero(static_cast<Eigen::Index>(tracks.numPoints()));
  for (std::size_t p = 0; p < tracks.numPoints(); ++p) {
    double sum = 0, weight = 0;
    for (std::uint32_t i = tracks.point_offsets[p]; i < tracks.point_offsets[p + 1]; ++i) {
      const std::uint32_t k = tracks.by_point[i];
      sum += static_cast<double>(equations.weights[k]) * equations.values[k];
      weight += equations.weights[k];
    }
    if (weight > 0) means[static_cast<Eigen::Index>(p)] = sum / weight;
  }
  return means;
}

/// H x = -g; the lower triangle of H, in triplets of scalar entries.
struct NormalEquations {
  std::vector<Eigen::Triplet<double>> lower;
  Eigen::VectorXd gradient;
};

/// O(sum over points of the square of their views). Each view's row is one task; the result does not depend on threads.
template <int D>
NormalEquations assemble(const Tracks& tracks, const Equations<D>& equations, const Workers& workers) {
  using Square = Eigen::Matrix<double, D, D>;
  const std::size_t num_views = tracks.numViews();
  const Eigen::VectorXd means = pointMeans(tracks, equations);
  NormalEquations result;
  result.gradient = Eigen::VectorXd::Zero(static_cast<Eigen::Index>(num_views) * D);
  std::vector<std::vector<Eigen::Triplet<double>>> rows(num_views);
  workers.forEach(num_views, [&](std::size_t v) {
    constexpr std::uint32_t kNone = ~std::uint32_t{0};
    std::vector<std::uint32_t> block_of(v + 1, kNone), used;  // of the views that share a point with this one
    std::vector<Square, Eigen::aligned_allocator<Square>> blocks;
    const auto blockAt = [&](std::size_t u) -> Square& {
      if (block_of[u] == kNone) {
        block_of[u] = static_cast<std::uint32_t>(blocks.size());
        blocks.push_back(Square::Zero());
        used.push_back(static_cast<std::uint32_t>(u));
      }
      return blocks[block_of[u]];
    };
    Eigen::Matrix<double, D, 1> gradient = Eigen::Matrix<double, D, 1>::Zero();
    blockAt(v);
    for (std::uint32_t k = tracks.offsets[v]; k < tracks.offsets[v + 1]; ++k) {
      const float w = equations.weights[k];
      if (!(w > 0)) continue;
      const std::uint32_t p = tracks.sights[k].point;
      const Eigen::Matrix<float, D, 1>& jacobian = equations.jacobians[k];
      const double residual = equations.values[k] - means[p];
      gradient += (w * residual) * jacobian.template cast<double>();
      float total = 0;
      for (std::uint32_t i = tracks.point_offsets[p]; i < tracks.point_offsets[p + 1]; ++i) {
        total += equations.weights[tracks.by_point[i]];
      }
      for (std::uint32_t i = tracks.point_offsets[p]; i < tracks.point_offsets[p + 1]; ++i) {
        const std::uint32_t other = tracks.by_point[i];
        const std::uint32_t u = tracks.views[other];
        if (u > v) break;
        const float factor = (other == k ? w : 0) - w * equations.weights[other] / total;
        if (factor == 0) continue;
        const Eigen::Matrix<float, D, D> block = factor * jacobian * equations.jacobians[other].transpose();
        blockAt(u) += block.template cast<double>();
      }
    }
    const auto base = static_cast<Eigen::Index>(v) * D;
    result.gradient.segment<D>(base) = gradient;
    std::sort(used.begin(), used.end());
    for (const std::uint32_t u : used) {
      for (int r = 0; r < D; ++r) {
        for (int c = 0; c < (u == v ? r + 1 : D); ++c) {
          rows[v].emplace_back(static_cast<int>(base) + r, static_cast<int>(u) * D + c, blocks[block_of[u]](r, c));
        }
      }
    }
  });
  for (auto& row : rows) {
    result.lower.insert(result.lower.end(), row.begin(), row.end());
    row = {};
  }
  return result;
}

/// X of A X = rhs, A by its lower triangle; nothing where A is singular or anything is not finite.
inline std::optional<Eigen::MatrixXd> solveLower(const Eigen::SparseMatrix<double>& lower, const Eigen::MatrixXd& rhs) {
  const Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>, Eigen::Lower> factor(lower);
  if (factor.info() != Eigen::Success) return std::nullopt;
  Eigen::MatrixXd solution = factor.solve(rhs);
  if (!solution.allFinite()) return std::nullopt;
  return solution;
}

}  // namespace cloud_colorizer::alignment
