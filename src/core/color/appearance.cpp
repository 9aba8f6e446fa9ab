// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause
#include "color/appearance.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "base/position_hash.hpp"
#include "base/robust.hpp"
#include "color/appearance_cells.hpp"

namespace cloud_colorizer {
namespace {

using Eigen::Index;
using Eigen::Vector3f;
using Functions = AppearanceBasis::Functions;

constexpr double kFitted = 0.25;  // share of the points that the strengths are found from
constexpr std::uint32_t kLeastSights = 3;
constexpr float kOwnPrior = 2;  // of a_p = 1: squares of a value's noise
constexpr float kMostOwn = 2;   // of a_p

/// Values and functions of the views of one point, and their means. The memory is kept from point to point.
struct PointSights {
  std::vector<Functions> functions;
  std::vector<float> weights;
  Eigen::Matrix3Xf values;
  Functions mean_functions;
  Vector3f mean_value;
  Vector3f normal;
  float weight = 0;

  std::size_t size() const { return weights.size(); }

  void look(const Sights& sights, const AppearanceBasis& basis, Index p) {
    const std::uint32_t first = sights.begin(p), last = sights.end(p);
    functions.clear();
    weights.clear();
    values = sights.observations.values.middleCols(first, last - first);
    normal = sights.facingNormal(p);
    for (std::uint32_t k = first; k < last; ++k) {
      functions.push_back(basis.at(normal, sights.toView(p, k)));
      weights.push_back(sights.observations.weights[k]);
    }
    average();
  }

  void average() {
    mean_functions.setZero();
    mean_value.setZero();
    weight = 0;
    for (std::size_t k = 0; k < size(); ++k) {
      mean_functions += weights[k] * functions[k];
      mean_value += weights[k] * values.col(static_cast<Index>(k));
      weight += weights[k];
    }
    if (!(weight > 0)) return;
    mean_functions /= weight;
    mean_value /= weight;
  }

  Functions functionsOf(std::size_t k) const { return functions[k] - mean_functions; }
  Vector3f valueOf(std::size_t k) const { return values.col(static_cast<Index>(k)) - mean_value; }

  void addTo(AppearanceMoments& moments) const {
    for (std::size_t k = 0; k < size(); ++k) {
      const Functions f = functionsOf(k);
      const Vector3f v = valueOf(k);
      const Functions weighted = weights[k] * f;
      moments.functions += weighted * f.transpose();
      moments.products += weighted * v.transpose();
      moments.squares += weights[k] * v.squaredNorm();
    }
    moments.weight += weight;
  }

  /// Views that the strengths do not explain count less.
  void doubt(const AppearanceCell& cell) {
    const float scale = std::sqrt(std::max(cell.noise, 1e-6F));
    for (std::size_t k = 0; k < size(); ++k) {
      const Vector3f rest = valueOf(k) - addedBy(cell.strengths, functionsOf(k));
      weights[k] *= cauchyWeight(rest.norm() / std::sqrt(3.F), scale);
    }
    average();
  }
};

bool canTell(const Sights& sights, Index p) {
  return sights.end(p) - sights.begin(p) >= kLeastSights && !sights.normals.col(p).isZero();
}

/// Sums up some of the points; `before`: what an earlier round found, or null.
AppearanceCells fitCells(const Sights& sights, const AppearanceBasis& basis, float side,
                         const AppearanceCells* before) {
  AppearanceCells cells(side);
  PointSights point;
  for (Index p = 0; p < sights.points.cols(); ++p) {
    if (!canTell(sights, p) || unitHash(sights.points.col(p)) >= kFitted) continue;
    point.look(sights, basis, p);
    const AppearanceCell* found = before != nullptr ? before->cellAt(sights.points.col(p), point.normal) : nullptr;
    if (found != nullptr) point.doubt(*found);
    if (point.weight > 0) point.addTo(cells.momentsAt(sights.points.col(p), point.normal));
  }
  return cells;
}

/// a_p: how much the point shows of what its neighbourhood does.
float ownShare(const PointSights& point, const AppearanceCells::Blend& blend, float noise) {
  float along = 0, across = 0;
  for (std::size_t k = 0; k < point.size(); ++k) {
    const Vector3f sheen = addedBy(blend.strengths, point.functionsOf(k));
    along += point.weights[k] * sheen.dot(point.valueOf(k));
    across += point.weights[k] * sheen.squaredNorm();
  }
  const float prior = kOwnPrior * noise;
  return across + prior > 0 ? std::clamp((along + prior) / (across + prior), 0.F, kMostOwn) : 0;
}

/// The views that show the least and the most, of those that count.
std::pair<Index, Index> ends(const Eigen::Matrix3Xf& taken, const std::vector<float>& weights) {
  Index least = -1, most = -1;
  for (Index k = 0; k < taken.cols(); ++k) {
    if (!(weights[static_cast<std::size_t>(k)] > 0)) continue;
    if (least < 0 || taken.col(k).sum() < taken.col(least).sum()) least = k;
    if (most < 0 || taken.col(k).sum() > taken.col(most).sum()) most = k;
  }
  return {least, most};
}

}  // namespace

Sheen takeOutSheen(const Sights& sights, Appearance appearance, float cell, Observations& observations) {
  const Index num_points = sights.points.cols();
  const Eigen::Matrix3Xf zeros = Eigen::Matrix3Xf::Zero(3, num_points);
  Sheen sheen{zeros, zeros, zeros};
  if (appearance == Appearance::kNone || observations.values.rows() != 3) return sheen;
  const AppearanceBasis basis(appearance, findLight(sights));
  AppearanceCells first = fitCells(sights, basis, cell, nullptr);
  first.solve();
  AppearanceCells cells = fitCells(sights, basis, cell, &first);
  if (!cells.solve()) return sheen;

  const float noise = cells.usualNoise();
  PointSights point;
  Eigen::Matrix3Xf taken;
  for (Index p = 0; p < num_points; ++p) {
    if (!canTell(sights, p)) continue;
    const AppearanceCells::Blend blend = cells.blendAt(sights.points.col(p), sights.facingNormal(p));
    if (blend.is_zero) continue;
    point.look(sights, basis, p);
    if (!(point.weight > 0)) continue;
    const Strengths own = ownShare(point, blend, noise) * blend.strengths;
    taken.resize(3, static_cast<Index>(point.size()));
    for (std::size_t k = 0; k < point.size(); ++k) {
      taken.col(static_cast<Index>(k)) = addedBy(own, point.functions[k]);
    }
    sheen.mean.col(p) = addedBy(own, point.mean_functions);
    const auto [least, most] = ends(taken, point.weights);
    sheen.least.col(p) = taken.col(least);
    sheen.most.col(p) = taken.col(most);
    observations.values.middleCols(sights.begin(p), taken.cols()) -= taken;
  }
  return sheen;
}

}  // namespace cloud_colorizer
