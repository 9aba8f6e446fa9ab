// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause
#include "cloud_colorizer/surfels.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <nanoflann.hpp>

#include "cloud_colorizer/check.hpp"

namespace cloud_colorizer {
namespace {

/// A neighbourhood is a plane when its variances a <= b <= c obey a < kFlat b and b > kLine c. A slab of noisy points
/// is far from flat at the scale of their spacing, hence the mild bound.
constexpr float kFlat = 0.35F;
constexpr float kLine = 0.04F;
/// Disc radius over the radius that holds k points. Points of spacing s have k = pi d^2 / s^2 of them within d, and
/// on a square grid discs of 0.71 s close the surface: d * 0.71 * sqrt(pi / k), and half as much again for
/// irregularity.
constexpr float kClosing = 1.05F * 1.7724539F;

struct Columns {
  const PointsRef& points;
  std::size_t kdtree_get_point_count() const { return static_cast<std::size_t>(points.cols()); }
  float kdtree_get_pt(std::size_t i, std::size_t axis) const {
    return points(static_cast<Eigen::Index>(axis), static_cast<Eigen::Index>(i));
  }
  template <class Box>
  bool kdtree_get_bbox(Box&) const {
    return false;
  }
};
using Tree =
    nanoflann::KDTreeSingleIndexAdaptor<nanoflann::L2_Simple_Adaptor<float, Columns>, Columns, 3, std::uint32_t>;

struct Neighbourhood {
  std::vector<std::uint32_t> indices;
  std::vector<float> squared_distances;  // ascending

  explicit Neighbourhood(std::size_t k) : indices(k), squared_distances(k) {}
  std::size_t size() const { return indices.size(); }
  float distance(std::size_t i) const { return std::sqrt(squared_distances[i]); }
};

struct Disc {
  Eigen::Vector3f normal = Eigen::Vector3f::Zero();
  float radius = 0, offset = 0;
  bool line = false;
};

/// Not a plane: a small ball that closes the gap to the nearest few points.
Disc ballOf(const Neighbourhood& near) {
  return {Eigen::Vector3f::Zero(), 0.5F * near.distance(near.size() / 3), 0, false};
}

Disc discOf(PointsRef points, const Eigen::Vector3f& center, const Neighbourhood& near) {
  Eigen::Vector3f mean = Eigen::Vector3f::Zero();
  Eigen::Matrix3f squares = Eigen::Matrix3f::Zero();
  for (const std::uint32_t j : near.indices) {
    const Eigen::Vector3f d = points.col(j) - center;
    mean += d;
    squares.noalias() += d * d.transpose();
  }
  const auto count = static_cast<float>(near.size());
  mean /= count;
  const Eigen::Matrix3f covariance = squares / count - mean * mean.transpose();
  Eigen::SelfAdjointEigenSolver<Eigen::Matrix3f> solver;
  solver.computeDirect(covariance);
  const Eigen::Vector3f variance = solver.eigenvalues();
  Disc disc = ballOf(near);
  if (!(variance[2] > 0)) return disc;  // all the same point
  disc.line = !(variance[1] > kLine * variance[2]);
  const Eigen::Vector3f normal = solver.eigenvectors().col(0);
  if (disc.line || !(variance[0] < kFlat * variance[1]) || !(std::abs(normal.squaredNorm() - 1) < 1e-3F)) return disc;
  const float farthest = near.distance(near.size() - 1);
  disc.normal = normal;
  // A far outlier among near points must not blow the disc up: the half of the neighbours bounds it too.
  disc.radius = kClosing / std::sqrt(count) * std::min(farthest, 1.8F * near.distance(near.size() / 2));
  disc.offset = std::min(disc.radius, std::max(-disc.radius, normal.dot(mean)));
  return disc;
}

}  // namespace

void SurfelParams::check() const {
  requireInRange("num_neighbors", num_neighbors, 4, 100);
}

Surfels estimateSurfels(PointsRef points, const SurfelParams& params) {
  params.check();
  const Eigen::Index n = points.cols();
  Surfels surfels{Eigen::Matrix3Xf::Zero(3, n), Eigen::VectorXf::Zero(n), Eigen::VectorXf::Zero(n)};
  if (n == 0) return surfels;
  require<std::invalid_argument>(points.allFinite(), "surfels: a point is not finite; drop such points first");
  const Columns columns{points};
  Tree tree(3, columns, nanoflann::KDTreeSingleIndexAdaptorParams(16));
  tree.buildIndex();
  const auto k = static_cast<std::size_t>(params.num_neighbors), available = static_cast<std::size_t>(n);
  Neighbourhood near(std::min(k, available)), wide(std::min(3 * k, available));
  const auto find = [&](Eigen::Index i, Neighbourhood& out) {
    tree.knnSearch(points.col(i).data(), out.size(), out.indices.data(), out.squared_distances.data());
  };
  for (Eigen::Index i = 0; i < n; ++i) {
    const Eigen::Vector3f center = points.col(i);
    find(i, near);
    Disc disc = discOf(points, center, near);
    if (disc.line && wide.size() > near.size()) {
      // Perhaps one scan line of a surface: with more neighbours the next line takes part.
      find(i, wide);
      const Disc wider = discOf(points, center, wide);
      if (!wider.normal.isZero()) {
        disc = wider;
        // Lines are dense along and sparse across, so the count says little: reach to the next line.
        disc.radius = std::max(disc.radius, 0.5F * wide.distance(wide.size() - 1));
      }
    }
    surfels.normals.col(i) = disc.normal;
    surfels.radii[i] = disc.radius;
    surfels.offsets[i] = disc.offset;
  }
  return surfels;
}

}  // namespace cloud_colorizer
