// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause
#include "cloud_colorizer/color/system.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <tuple>
#include <utility>

#include "base/position_hash.hpp"
#include "cloud_colorizer/base/check.hpp"

namespace cloud_colorizer {
namespace {

using Eigen::Index;

/// Whether the lot of point p is the least of the `window` lots around it.
bool isLeast(const std::vector<double>& lots, std::size_t p, std::size_t window) {
  const std::size_t begin = p - std::min(p, (window - 1) / 2), end = std::min(lots.size(), p + window / 2 + 1);
  return std::none_of(lots.begin() + static_cast<std::ptrdiff_t>(begin),
                      lots.begin() + static_cast<std::ptrdiff_t>(end),
                      [lot = lots[p]](double other) { return other < lot; });
}

void anchorRandom(PointsRef points, const Fused& fused, double share, Eigen::VectorXf& weights) {
  if (!(share > 0)) return;
  std::vector<double> lots(static_cast<std::size_t>(points.cols()));
  for (std::size_t p = 0; p < lots.size(); ++p) lots[p] = unitHash(points.col(static_cast<Index>(p)));
  // One of n is the least of n. If 1 / share is no whole number, so many points look at n others that, with n + 1 for
  // the rest, the share is right on average.
  const double all = 2 * static_cast<double>(lots.size()) + 1;  // others around the first or the last
  const auto narrow = static_cast<std::size_t>(std::min(all, (1 + 1e-9) / share));
  const double share_narrow = static_cast<double>(narrow) * (share * static_cast<double>(narrow + 1) - 1);
  for (std::size_t p = 0; p < lots.size(); ++p) {
    const auto node = static_cast<Index>(p);
    if (fused.count(node) == 0 || !isLeast(lots, p, narrow)) continue;
    const double second_lot = std::fmod(lots[p] * 0x1p24, 1.0);
    if (second_lot < share_narrow || isLeast(lots, p, narrow + 1)) weights(node) = 1;
  }
}

void anchorConsistent(PointsRef points, const Fused& fused, double share, Eigen::VectorXf& weights) {
  std::vector<std::tuple<float, double, Index>> candidates;
  for (Index p = 0; p < points.cols(); ++p) {
    if (fused.count(p) >= 2) candidates.emplace_back(fused.stddev(p), unitHash(points.col(p)), p);
  }
  const auto wanted = static_cast<std::size_t>(std::llround(share * static_cast<double>(points.cols())));
  const std::size_t num_anchors = std::min(wanted, candidates.size());
  const auto end = candidates.begin() + static_cast<std::ptrdiff_t>(num_anchors);
  std::nth_element(candidates.begin(), end, candidates.end());
  std::for_each(candidates.begin(), end, [&](const auto& candidate) { weights(std::get<2>(candidate)) = 1; });
}

/// Without an anchor a component's colours are free up to a constant: the matrix would be singular.
void anchorComponents(const Fused& fused, const std::vector<Edge>& edges, Eigen::VectorXf& weights) {
  const auto num_points = static_cast<std::size_t>(weights.size());
  const std::vector<std::uint32_t> labels = connectedComponents(num_points, edges);
  constexpr Index kNone = -1, kAnchored = -2;
  std::vector<Index> best(labels.empty() ? 0 : *std::max_element(labels.begin(), labels.end()) + 1, kNone);
  for (std::size_t p = 0; p < num_points; ++p) {
    const auto node = static_cast<Index>(p);
    Index& chosen = best[labels[p]];
    if (weights(node) == 1) {
      chosen = kAnchored;
    } else if (chosen == kNone || (chosen != kAnchored && fused.count(node) > fused.count(chosen))) {
      chosen = node;
    }
  }
  for (const Index node : best) {
    if (node >= 0) weights(node) = 1;
  }
}

/// Sums of the values' differences over the views that two points have in common.
class CommonViews {
 public:
  CommonViews(const Observations& observations, double max_distance, const Eigen::VectorXf& weights)
      : observations_(observations), weights_(weights), max_distance_(max_distance) {}

  /// Writes g(p,q) into `gradient`, which comes as zeros; false if there is no evidence. Merges two sorted lists.
  bool meanDifference(const Edge& edge, float* gradient) const {
    const auto& offsets = observations_.offsets;
    const auto& views = observations_.views;
    float total = 0;
    std::uint32_t a = offsets[edge.p], b = offsets[edge.q];
    while (a < offsets[edge.p + 1] && b < offsets[edge.q + 1]) {
      if (views[a] == views[b]) {
        total += addDifference(a++, b++, gradient);
      } else {
        views[a] < views[b] ? ++a : ++b;
      }
    }
    const Index channels = observations_.values.rows();
    if (!(total > 0)) return false;
    for (Index c = 0; c < channels; ++c) gradient[c] /= total;
    return true;
  }

 private:
  bool isNear(std::uint32_t observation) const {
    return max_distance_ <= 0 || observations_.distances[observation] <= max_distance_;
  }

  float addDifference(std::uint32_t a, std::uint32_t b, float* sum) const {
    if (!isNear(a) || !isNear(b)) return 0;
    const float weight = weights_.size() > 0 ? weights_(a) * weights_(b) : 1.0F;
    const Index channels = observations_.values.rows();
    const float* value_a = observations_.values.data() + channels * static_cast<Index>(a);
    const float* value_b = observations_.values.data() + channels * static_cast<Index>(b);
    for (Index c = 0; c < channels; ++c) sum[c] += weight * (value_a[c] - value_b[c]);
    return weight;
  }

  const Observations& observations_;
  const Eigen::VectorXf& weights_;
  double max_distance_;
};

void checkEdges(const std::vector<Edge>& edges, std::size_t num_points) {
  for (std::size_t e = 0; e < edges.size(); ++e) {
    const Edge& edge = edges[e];
    require<std::invalid_argument>(edge.p < edge.q && edge.q < num_points, "edge ", e, " = (", edge.p, ", ", edge.q,
                                   ") of ", num_points, " points must have p < q < number of points");
    require<std::invalid_argument>(e == 0 || std::tie(edges[e - 1].p, edges[e - 1].q) < std::tie(edge.p, edge.q),
                                   "edge ", e, " = (", edge.p, ", ", edge.q, ") must ascend by (p, q)");
  }
}

/// Lays out the lower triangle: in every column the diagonal, then one entry an edge. The off-diagonals are set.
Eigen::SparseMatrix<double> lowerTriangle(const std::vector<Edge>& edges, Index num_points, double lambda) {
  const auto used = std::count_if(edges.begin(), edges.end(), [](const Edge& edge) { return edge.weight > 0; });
  require<std::out_of_range>(used + num_points <= std::numeric_limits<int>::max(), used, " edges of ", num_points,
                             " points exceed 32-bit indices; use smaller chunks");
  Eigen::SparseMatrix<double> matrix(num_points, num_points);
  matrix.resizeNonZeros(used + num_points);
  int next = 0;
  auto edge = edges.begin();
  for (Index p = 0; p < num_points; ++p) {
    matrix.outerIndexPtr()[p] = next;
    matrix.innerIndexPtr()[next] = static_cast<int>(p);
    matrix.valuePtr()[next++] = 0;
    for (; edge != edges.end() && edge->p == p; ++edge) {
      if (!(edge->weight > 0)) continue;
      matrix.innerIndexPtr()[next] = static_cast<int>(edge->q);
      matrix.valuePtr()[next++] = -lambda * edge->weight;
    }
  }
  matrix.outerIndexPtr()[num_points] = next;
  return matrix;
}

}  // namespace

void SystemParams::check() const {
  requireInRange("lambda", lambda, 1e-6, 1e6);
  requireInRange("anchor_share", anchor_share, 0.0, 1.0);
  requireInRange("gradient_distance", gradient_distance, 0.0, 1e6);
  requireInRange("min_data_weight", min_data_weight, 0.0, 1.0);
  requireInRange("no_evidence_weight", no_evidence_weight, 0.0, 1.0);
}

Gradients edgeGradients(const std::vector<Edge>& edges, const Observations& observations, double gradient_distance,
                        const Eigen::VectorXf& observation_weights) {
  checkEdges(edges, observations.numPoints());
  require<std::invalid_argument>(observation_weights.size() == 0 ||
                                     observation_weights.size() == static_cast<Index>(observations.numObservations()),
                                 observation_weights.size(), " observation weights for ",
                                 observations.numObservations(), " observations");
  const CommonViews common(observations, gradient_distance, observation_weights);
  Gradients gradients;
  gradients.values.setZero(observations.values.rows(), static_cast<Index>(edges.size()));
  gradients.has_evidence.resize(edges.size());
  for (std::size_t e = 0; e < edges.size(); ++e) {
    float* gradient = gradients.values.data() + gradients.values.rows() * static_cast<Index>(e);
    gradients.has_evidence[e] = common.meanDifference(edges[e], gradient);
  }
  return gradients;
}

std::vector<Edge> weighEvidence(std::vector<Edge> edges, const Gradients& gradients, double no_evidence_weight) {
  require<std::invalid_argument>(gradients.has_evidence.size() == edges.size(), gradients.has_evidence.size(),
                                 " gradients for ", edges.size(), " edges");
  for (std::size_t e = 0; e < edges.size(); ++e) {
    if (!gradients.has_evidence[e]) edges[e].weight *= static_cast<float>(no_evidence_weight);
  }
  return edges;
}

Eigen::VectorXf dataWeights(PointsRef points, const Fused& fused, const std::vector<Edge>& edges,
                            const SystemParams& params) {
  params.check();
  require<std::invalid_argument>(fused.count.size() == points.cols() && fused.stddev.size() == points.cols(),
                                 fused.count.size(), " fused values for ", points.cols(), " points");
  Eigen::VectorXf weights = (fused.count.array() > 0).cast<float>() * static_cast<float>(params.min_data_weight);
  const auto anchor = params.anchors == AnchorKind::kRandom ? anchorRandom : anchorConsistent;
  anchor(points, fused, params.anchor_share, weights);
  anchorComponents(fused, edges, weights);
  return weights;
}

LinearSystem assembleSystem(const std::vector<Edge>& edges, ValuesRef gradients, ValuesRef data,
                            const Eigen::VectorXf& data_weights, double lambda) {
  const Index num_points = data.cols();
  require<std::invalid_argument>(
      data_weights.size() == num_points && gradients.cols() == static_cast<Index>(edges.size()) &&
          gradients.rows() == data.rows(),
      "gradients ", gradients.rows(), " x ", gradients.cols(), ", data ", data.rows(), " x ", num_points, ", ",
      data_weights.size(), " data weights and ", edges.size(), " edges do not fit together");
  checkEdges(edges, static_cast<std::size_t>(num_points));
  LinearSystem system;
  system.matrix = lowerTriangle(edges, num_points, lambda);
  Eigen::VectorXd diagonal = data_weights.cast<double>();
  Eigen::MatrixXd rhs = data.cast<double>() * diagonal.asDiagonal();  // m x n: a point's channels side by side
  for (std::size_t e = 0; e < edges.size(); ++e) {
    const Edge& edge = edges[e];
    if (!(edge.weight > 0)) continue;
    const double weight = lambda * edge.weight;
    diagonal(edge.p) += weight;
    diagonal(edge.q) += weight;
    for (Index c = 0; c < rhs.rows(); ++c) {
      const double term = weight * gradients(c, static_cast<Index>(e));
      rhs(c, edge.p) += term;  // g(p,q)
      rhs(c, edge.q) -= term;  // g(q,p)
    }
  }
  for (Index p = 0; p < num_points; ++p) system.matrix.valuePtr()[system.matrix.outerIndexPtr()[p]] = diagonal(p);
  system.rhs = rhs.transpose();
  return system;
}

}  // namespace cloud_colorizer
