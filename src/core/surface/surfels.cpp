// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause
#include "cloud_colorizer/surface/surfels.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <vector>

#include "cloud_colorizer/base/check.hpp"
#include "cloud_colorizer/surface/zorder.hpp"
#include "surface/kdtree.hpp"

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

/// Near points in a row keep the search in the caches.
std::vector<std::uint32_t> coarseOrder(PointsRef points) {
  return zorderSort(zorderKeys(points, gridOf(points, 10)), 0);
}

/// Count, sum and sum of squares of points about a centre.
struct Moments {
  float count = 0;
  Eigen::Vector3f sum = Eigen::Vector3f::Zero();
  Eigen::Matrix3f squares = Eigen::Matrix3f::Zero();

  void add(const Eigen::Vector3f& d) {
    count += 1;
    sum += d;
    squares.noalias() += d * d.transpose();
  }
  /// Those of another centre, which lies at `d` from this one.
  void add(const Moments& other, const Eigen::Vector3f& d) {
    count += other.count;
    sum += other.sum + other.count * d;
    const Eigen::Matrix3f cross = other.sum * d.transpose();
    squares += other.squares + cross + cross.transpose() + other.count * d * d.transpose();
  }
};

struct Plane {
  Eigen::Vector3f normal = Eigen::Vector3f::Zero();
  float offset = 0;
  bool line = false;
};

Plane planeOf(const Moments& moments) {
  Plane plane;
  const Eigen::Vector3f mean = moments.sum / moments.count;
  const Eigen::Matrix3f covariance = moments.squares / moments.count - mean * mean.transpose();
  Eigen::SelfAdjointEigenSolver<Eigen::Matrix3f> solver;
  solver.computeDirect(covariance);
  const Eigen::Vector3f variance = solver.eigenvalues();
  if (!(variance[2] > 0)) return plane;  // all the same point
  plane.line = !(variance[1] > kLine * variance[2]);
  const Eigen::Vector3f normal = solver.eigenvectors().col(0);
  const bool unit = std::abs(normal.squaredNorm() - 1) < 1e-3F;
  if (plane.line || !unit || !(variance[0] < kFlat * variance[1])) return plane;
  plane.normal = normal;
  plane.offset = normal.dot(mean);
  return plane;
}

/// The neighbourhoods of all points: k columns of indices, and the distances that radii are made of.
class Estimator {
 public:
  Estimator(const Points& points, std::size_t k)
      : points_(points), tree_(points_), k_(std::min(k, static_cast<std::size_t>(points.cols()))) {
    const auto n = static_cast<std::size_t>(points.cols());
    moments_.resize(n);
    neighbors_.resize(n * k_);
    squared_.resize(k_);
    spans_.resize(n);
    for (std::size_t i = 0; i < n; ++i) {
      std::uint32_t* const near = neighbors_.data() + i * k_;
      tree_.nearest(at(i), k_, near, squared_.data());
      for (std::size_t j = 0; j < k_; ++j) moments_[i].add(at(near[j]) - at(i));
      spans_[i] = {std::sqrt(squared_[k_ / 3]), std::sqrt(squared_[k_ / 2]), std::sqrt(squared_[k_ - 1])};
    }
  }

  /// Of point i, into its column of `out`.
  void estimate(std::size_t i, Surfels& out) {
    // The neighbours' neighbours as well: noise of the normal falls with the square of the neighbourhood.
    Moments moments;
    const std::uint32_t* const near = neighbors_.data() + i * k_;
    for (std::size_t j = 0; j < k_; ++j) moments.add(moments_[near[j]], at(near[j]) - at(i));
    Plane plane = planeOf(moments);
    const auto [third, half, whole] = spans_[i];
    // A far outlier among near points must not blow the disc up: the half of the neighbours bounds it too.
    float radius = kClosing / std::sqrt(static_cast<float>(k_)) * std::min(whole, 1.8F * half);
    if (plane.line) plane = planeAcrossLines(i, radius);
    if (plane.normal.isZero()) radius = 0.5F * third;  // not a plane: a small ball
    const auto column = static_cast<Eigen::Index>(i);
    out.normals.col(column) = plane.normal;
    out.radii[column] = radius;
    out.offsets[column] = std::min(radius, std::max(-radius, plane.offset));
  }

  /// What a plane through the neighbours of a curved surface lies too deep by, m along the normal of point i: the mean
  /// of the neighbours' own offsets, as far as their scatter lets it be told. On a slab of noisy points it is nothing.
  float curvatureOffset(std::size_t i, const Surfels& planes) const {
    constexpr float kScatter = 0.25F;  // of the variance: more than noise of a mean over the neighbours' neighbours has
    const Eigen::Vector3f normal = planes.normals.col(static_cast<Eigen::Index>(i));
    const std::uint32_t* const near = neighbors_.data() + i * k_;
    float sum = 0, squares = 0, weight = 0;
    for (std::size_t j = 0; j < k_; ++j) {
      const float cosine = normal.dot(planes.normals.col(near[j])), offset = planes.offsets[near[j]];
      sum += cosine * std::abs(cosine) * offset;  // an edge's other side counts little
      squares += cosine * cosine * offset * offset;
      weight += cosine * cosine;
    }
    if (sum == 0) return 0;
    const float mean = sum / weight, variance = squares / weight - mean * mean;
    return mean * std::max(0.0F, 1 - kScatter * variance / (mean * mean));
  }

 private:
  Eigen::Vector3f at(std::size_t i) const { return points_.col(static_cast<Eigen::Index>(i)); }

  /// Perhaps one scan line of a surface: with more neighbours the next line takes part. Lines are dense along and
  /// sparse across, so the radius has to reach to the next line.
  Plane planeAcrossLines(std::size_t i, float& radius) {
    const std::size_t many = std::min(4 * k_, static_cast<std::size_t>(points_.cols()));
    wide_.resize(many);
    squared_.resize(many);
    tree_.nearest(at(i), many, wide_.data(), squared_.data());
    Moments moments;
    for (const std::uint32_t j : wide_) moments.add(at(j) - at(i));
    Plane plane = planeOf(moments);
    if (!plane.normal.isZero()) radius = std::max(radius, 0.5F * std::sqrt(squared_.back()));
    return plane;
  }

  struct Spans {
    float third, half, whole;  // m to the neighbours of these ranks
  };
  const Points& points_;
  KdTree tree_;
  std::size_t k_;
  std::vector<std::uint32_t> neighbors_, wide_;
  std::vector<float> squared_;
  std::vector<Moments> moments_;
  std::vector<Spans> spans_;
};

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
  const std::vector<std::uint32_t> order = coarseOrder(points);
  Points sorted(3, n);
  for (std::size_t i = 0; i < order.size(); ++i) sorted.col(static_cast<Eigen::Index>(i)) = points.col(order[i]);
  Estimator estimator(sorted, static_cast<std::size_t>(params.num_neighbors));
  Surfels planes = surfels;  // in the order of `sorted`
  for (std::size_t i = 0; i < order.size(); ++i) estimator.estimate(i, planes);
  for (std::size_t i = 0; i < order.size(); ++i) {
    const auto from = static_cast<Eigen::Index>(i);
    surfels.normals.col(order[i]) = planes.normals.col(from);
    surfels.radii[order[i]] = planes.radii[from];
    surfels.offsets[order[i]] = planes.offsets[from] - estimator.curvatureOffset(i, planes);
  }
  return surfels;
}

}  // namespace cloud_colorizer
