// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause
#include "surface/patch.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

namespace cloud_colorizer {
namespace {

/// Points lie on a line when their middle variance is not above this share of the greatest.
constexpr float kLine = 0.04F;
/// A bend is believed as far as its square is above this many times its variance.
constexpr float kBelief = 3;
constexpr float kLeastVariance = 1e-6F;  // of a variance, in square cells: below it is rounding

}  // namespace

Patch fitPlane(const Moments& moments) {
  Patch patch;
  patch.shape = Patch::Shape::kNone;
  Eigen::SelfAdjointEigenSolver<Eigen::Matrix3f> solver;
  solver.computeDirect(moments.covariance());
  const Eigen::Vector3f variance = solver.eigenvalues().cwiseMax(0.0F);
  if (!(variance[2] > 0)) return patch;
  patch.width = std::sqrt(variance[1]);
  patch.density = moments.count / std::sqrt(std::max(kLeastVariance, variance[0]) * variance[1] * variance[2]);
  patch.variance = variance[0];
  patch.shape = variance[1] > kLine * variance[2] ? Patch::Shape::kSurface : Patch::Shape::kLine;
  if (patch.shape == Patch::Shape::kLine) return patch;
  patch.normal = solver.eigenvectors().col(0);
  if (!(std::abs(patch.normal.squaredNorm() - 1) < 1e-3F)) patch.shape = Patch::Shape::kNone;
  patch.mean = moments.mean();
  patch.variance = variance[0];
  patch.extent = variance[1] + variance[2];
  patch.ratio = variance[0] / variance[1];
  // A rectangle of sides a and b has the variances a^2 / 12 and b^2 / 12.
  patch.spacing = std::sqrt(12 * std::sqrt(variance[1] * variance[2]) / moments.count);
  return patch;
}

void bendPatch(const CellLevel& level, const CellNeighbors& neighbors, Patch& patch) {
  // Regression of the height on the squared distance along the plane, of the means over the cells.
  float cells = 0, count = 0, x = 0, y = 0, xx = 0, xy = 0, yy = 0;
  for (const auto& neighbor : neighbors) {
    const Moments& moments = level.moments(neighbor.cell);
    const Eigen::Vector3f d = moments.mean() + neighbor.offset - patch.mean;
    const Eigen::Matrix3f scatter = moments.covariance();
    const float height = patch.normal.dot(d), along = scatter.trace() - patch.normal.dot(scatter * patch.normal);
    const float squared = d.squaredNorm() - height * height + std::max(0.0F, along);
    cells += 1, count += moments.count;
    x += moments.count * squared, y += moments.count * height;
    xx += moments.count * squared * squared, xy += moments.count * squared * height;
    yy += moments.count * height * height;
  }
  const float spread = xx - x * x / count, slope = (xy - x * y / count) / spread;
  const float explained = slope * slope * spread;  // of the sum of squares along the normal
  if (!(spread > 0) || !(explained > 0)) return;
  const float residual = std::max(0.0F, yy - y * y / count - explained) / std::max(1.0F, cells - 2);
  const float belief = std::max(0.0F, 1 - kBelief * residual / explained);
  patch.bend = belief * slope;
  patch.rise = -patch.bend * patch.extent;
  patch.variance -= belief * std::min(patch.variance, explained / count);
}

}  // namespace cloud_colorizer
