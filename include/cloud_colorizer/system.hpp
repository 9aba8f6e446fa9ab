// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause

/// The linear system of eq. (5) and its solution: factor once, solve n x m.
#pragma once

#include <Eigen/SparseCore>
#include <memory>
#include <string>
#include <vector>

#include "cloud_colorizer/fuse.hpp"
#include "cloud_colorizer/graph.hpp"
#include "cloud_colorizer/observe.hpp"
#include "cloud_colorizer/types.hpp"

namespace cloud_colorizer {

enum class SolverKind { kCholmod, kSpqr };
enum class AnchorKind { kRandom, kConsistent };

struct SystemParams {
  double lambda = 1;                         ///< weight of the gradients against the data, eq. (1)
  AnchorKind anchors = AnchorKind::kRandom;  ///< which points have a_p = 1
  double anchor_share = 0.1;                 ///< share of the points that are anchors
  double gradient_distance = 0;              ///< m; U(p) of eq. (4): views within this distance; 0: all views
  double min_data_weight = 1e-3;             ///< a_p of every other seen point, against drift; 0 as in the paper
  double no_evidence_weight = 0.01;          ///< weight of an edge with no view in common; 0 drops it
  SolverKind solver = SolverKind::kCholmod;

  void check() const;
};

/// g(p,q) of eq. (4) for every edge, m x number of edges, and whether there was any view in common.
struct Gradients {
  Values values;
  std::vector<std::uint8_t> has_evidence;
};
Gradients edgeGradients(const std::vector<Edge>& edges, const Observations& observations, double gradient_distance);

/// a_p: 1 for the anchors, min_data_weight for the others. Random anchors are a hash of the point's position
/// (`positions` as stored, so that every chunk makes the same choice); consistent ones are the share with the least
/// stddev among those seen by two views or more. Every component of the graph gets at least one anchor.
Eigen::VectorXf dataWeights(PointsRef points, const Fused& fused, const std::vector<Edge>& edges,
                            const SystemParams& params);

/// A x = b of eq. (5); A is symmetric positive definite, only its lower triangle is stored.
struct LinearSystem {
  Eigen::SparseMatrix<double> matrix;  ///< n x n
  Eigen::MatrixXd rhs;                 ///< n x m
};
LinearSystem assembleSystem(const std::vector<Edge>& edges, const Gradients& gradients, ValuesRef data,
                            const Eigen::VectorXf& data_weights, const SystemParams& params);

/// The constructor is the factorisation. Throws std::runtime_error, with the reason, on a singular matrix.
class Factorization {
 public:
  Factorization(const Eigen::SparseMatrix<double>& lower, SolverKind solver);
  ~Factorization();
  Factorization(Factorization&&) noexcept;
  Eigen::MatrixXd solve(const Eigen::MatrixXd& rhs) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace cloud_colorizer
