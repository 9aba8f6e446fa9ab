// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause

/// The linear system of eq. (5) and the parts it is made of.
#pragma once

#include <Eigen/SparseCore>
#include <cstdint>
#include <vector>

#include "cloud_colorizer/base/types.hpp"
#include "cloud_colorizer/color/fuse.hpp"
#include "cloud_colorizer/color/graph.hpp"
#include "cloud_colorizer/color/linear_solver.hpp"
#include "cloud_colorizer/visibility/observe.hpp"

namespace cloud_colorizer {

enum class AnchorKind { kRandom, kConsistent };

struct SystemParams {
  double lambda = 1;                         ///< weight of the gradients against the data, eq. (1)
  AnchorKind anchors = AnchorKind::kRandom;  ///< which points have a_p = 1
  double anchor_share = 0.1;                 ///< share of the points that are anchors
  double gradient_distance = 0;              ///< m; U(p) of eq. (4): views within this distance; 0: all views
  double min_data_weight = 1e-3;             ///< a_p of every other seen point, against drift; 0 as in the paper
  double no_evidence_weight = 0.01;          ///< weight of an edge with no view in common; 0 drops it
  SolverKind solver = SolverKind::kConjugateGradients;

  void check() const;
};

/// g(p,q) of eq. (4) for every edge, m x number of edges, and whether there was any view in common; if not, g = 0.
struct Gradients {
  Values values;
  std::vector<std::uint8_t> has_evidence;
};

/// The plain mean of v_p^i - v_q^i over the views i within gradient_distance (0: all) of both p and q. With
/// `observation_weights` (Fused::observation_weights; one for every observation, or none) it is the mean weighted by
/// w_p^i w_q^i: a view that is an outlier at one end says nothing about the edge. All weights 0 is no evidence.
Gradients edgeGradients(const std::vector<Edge>& edges, const Observations& observations, double gradient_distance,
                        const Eigen::VectorXf& observation_weights = Eigen::VectorXf());

/// The edges with the weight that they have in the system: those without evidence times no_evidence_weight. At 0 they
/// stay in the list, as gradients go by its index, but they are no edges any more.
std::vector<Edge> weighEvidence(std::vector<Edge> edges, const Gradients& gradients, double no_evidence_weight);

/// a_p: 1 for the anchors, min_data_weight for the other seen points, 0 for a point without views.
/// A random anchor is one whose hash of the position (as stored) is the least of the 1 / anchor_share points around it
/// in the order given. In Z-order the anchors are then spread evenly over the surface (less noise than from lots that
/// every point draws by itself), and chunks that share points make the same choice but at their borders.
/// Consistent ones are the share of all points with the least stddev among those of two views or more, ties by
/// the hash; the threshold is that of the points given, so chunks may differ in it a little.
/// Every component of the graph without an anchor gets one: the point with the most views, ties by index.
Eigen::VectorXf dataWeights(PointsRef points, const Fused& fused, const std::vector<Edge>& edges,
                            const SystemParams& params);

/// A x = b of eq. (5); A is symmetric positive definite, only its lower triangle is stored.
struct LinearSystem {
  Eigen::SparseMatrix<double> matrix;  ///< n x n, compressed, rows ascending
  Eigen::MatrixXd rhs;                 ///< n x m
};

/// Half the derivative of E by c_p, zero for every p, with w_pq the weight of an edge and g(q,p) = -g(p,q):
///   (a_p + lambda sum_q w_pq) c_p - lambda sum_q w_pq c_q = a_p data_p + lambda sum_q w_pq g(p,q)
/// `edges` ascend by (p, q) with p < q, `gradients` is m x number of edges, `data` m x n. One pass, no sort: then the
/// edges are the lower triangle's columns already. At most 2^31 - 1 entries, else std::out_of_range.
LinearSystem assembleSystem(const std::vector<Edge>& edges, ValuesRef gradients, ValuesRef data,
                            const Eigen::VectorXf& data_weights, double lambda);

}  // namespace cloud_colorizer
