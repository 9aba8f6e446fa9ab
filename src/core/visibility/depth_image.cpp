// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause
#include "cloud_colorizer/visibility/depth_image.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <limits>
#include <opencv2/imgproc.hpp>

#include "cloud_colorizer/base/check.hpp"

namespace cloud_colorizer {
namespace {

constexpr double kLeastCell = 2, kCellsOfImage = 640;  // px; along its longer side
constexpr float kMaxSplat = 32;                        // cells; half the extent of the largest splat
constexpr float kLowPass = 0.5F;                       // cells; added to every splat so that neighbours join
constexpr float kMaxShare = 0.3F;        // of the distance: a disc's radius at most, as nearer discs cross the camera
constexpr float kMinCosine = 0.05F;      // of the incidence; more grazing ones count as this
constexpr float kThickness = 0.25F;      // of the radius: how far a visible point may lie below the surface
constexpr float kBallThickness = 0.6F;   // the same without a plane
constexpr float kSlabDeviations = 2.5F;  // of the thickness, the same
constexpr float kCellSlack = 1.0F;       // cells: a cell holds the nearest of a slanted surface in and just beside it
constexpr float kRangeShare = 0.01F;     // of the distance: what a scan's range may differ by at least,
constexpr float kMaxRangeShare = 0.05F;  // and at most
constexpr float kMaxTangent = 8;         // of the incidence on a surface that a scan measured
constexpr float kJump = 0.04F;           // relative change of depth between cells that is an edge

/// A splat: the ellipse a du^2 + 2 b du dv + c dv^2 <= 1 about (u, v) and its plane of inverse distance. In cells.
struct Ellipse {
  float u, v, a, b, c;
  float half_width, half_height;
  float inverse, du, dv;    // inverse distance at the centre and its gradient
  float nearest, farthest;  // bounds of the inverse distance
};

/// floor and ceil of what is above -256, without a library call; a cell's thousandth is not worth one.
int floorOf(float x) {
  return static_cast<int>(x + 256) - 256;
}
int ceilOf(float x) {
  return static_cast<int>(x + 256.999F) - 256;
}

/// Rows: v; the span of u is where the quadratic is below 1; the cell of the centre is always covered.
void fill(const Ellipse& e, cv::Mat1f& inverse) {
  const int center_u = floorOf(e.u + 0.5F), center_v = floorOf(e.v + 0.5F);
  const int first_v = std::max(0, std::min(center_v, ceilOf(e.v - e.half_height)));
  const int last_v = std::min(inverse.rows - 1, std::max(center_v, floorOf(e.v + e.half_height)));
  const float over_a = 1 / e.a, determinant = e.b * e.b - e.a * e.c;
  for (int row = first_v; row <= last_v; ++row) {
    const float y = static_cast<float>(row) - e.v;
    const float root = determinant * y * y + e.a;
    if (root < 0 && row != center_v) continue;
    const float middle = e.u - e.b * y * over_a, half = std::sqrt(std::max(root, 0.0F)) * over_a;
    int first_u = ceilOf(middle - half), last_u = floorOf(middle + half);
    if (row == center_v) first_u = std::min(first_u, center_u), last_u = std::max(last_u, center_u);
    first_u = std::max(first_u, 0), last_u = std::min(last_u, inverse.cols - 1);
    float* const cells = inverse[row];
    const float start = e.inverse + e.dv * y - e.du * e.u;
    for (int col = first_u; col <= last_u; ++col) {
      const float at = std::min(e.nearest, std::max(e.farthest, start + e.du * static_cast<float>(col)));
      cells[col] = std::max(cells[col], at);
    }
  }
}

/// One cell without a surface, or with a much farther one than two opposite neighbours, is a hole between surfels.
cv::Mat1f closeHoles(const cv::Mat1f& inverse) {
  cv::Mat1f closed = inverse.clone();
  for (int row = 0; row < inverse.rows; ++row) {
    for (int col = 0; col < inverse.cols; ++col) {
      float& cell = closed(row, col);
      if (col > 0 && col + 1 < inverse.cols) {
        cell = std::max(cell, std::min(inverse(row, col - 1), inverse(row, col + 1)));
      }
      if (row > 0 && row + 1 < inverse.rows) {
        cell = std::max(cell, std::min(inverse(row - 1, col), inverse(row + 1, col)));
      }
    }
  }
  return closed;
}

/// Of four cells in a row: is there a depth edge between the middle two? Planes are linear in inverse distance, so
/// what either side continues is no edge, however grazing.
bool isJump(float before, float first, float second, float after) {
  const float least = kJump * std::max(first, second);
  if (std::abs(first - second) <= least) return false;
  return std::abs(2 * first - before - second) > least && std::abs(2 * second - after - first) > least;
}

float supportOf(float behind, float allowed) {
  const float ratio = std::max(0.0F, behind) / std::max(1e-9F, allowed);
  return 1 - std::min(2.0F, ratio * ratio);
}

cv::Mat1b findEdges(const cv::Mat1f& inverse, int guard) {
  cv::Mat1b edge(inverse.size(), 0);
  if (guard <= 0) return edge;
  const int rows = inverse.rows, cols = inverse.cols;
  for (int row = 0; row < rows; ++row) {
    const float* const at = inverse[row];
    for (int col = 0; col + 1 < cols; ++col) {
      if (!isJump(at[std::max(col - 1, 0)], at[col], at[col + 1], at[std::min(col + 2, cols - 1)])) continue;
      edge(row, col) = edge(row, col + 1) = 255;
    }
  }
  for (int row = 0; row + 1 < rows; ++row) {
    const float *const before = inverse[std::max(row - 1, 0)], *const first = inverse[row];
    const float *const second = inverse[row + 1], *const after = inverse[std::min(row + 2, rows - 1)];
    for (int col = 0; col < cols; ++col) {
      if (isJump(before[col], first[col], second[col], after[col])) edge(row, col) = edge(row + 1, col) = 255;
    }
  }
  if (guard > 1) {  // the two cells of a jump are the first of the band
    const cv::Size size(2 * guard - 1, 2 * guard - 1);
    cv::dilate(edge, edge, cv::getStructuringElement(cv::MORPH_RECT, size));
  }
  return edge;
}

}  // namespace

void DepthParams::check() const {
  if (depth_cell_size != 0) requireInRange("depth_cell_size", depth_cell_size, 0.5, 64.0);
  requireInRange("depth_tolerance", depth_tolerance, 0.0, 0.5);
  requireInRange("depth_edge_guard", depth_edge_guard, 0.0, 100.0);
  requireInRange("max_view_distance", max_view_distance, 0.0, std::numeric_limits<double>::infinity());
  requireInRange("clear_radius", clear_radius, 0.0, 100.0);
}

double DepthParams::reach(double max_range) const {
  return max_view_distance > 0 ? max_view_distance : max_range / 1.5;
}

double DepthParams::cellSize(const Intrinsics& intrinsics) const {
  if (depth_cell_size > 0) return depth_cell_size;
  return std::max(kLeastCell, std::max(intrinsics.width, intrinsics.height) / kCellsOfImage);
}

/// Depth change to the next cell [m a cell]: the lesser of the two sides, so that a depth edge does not count.
float DepthImage::slope(int row, int col) const {
  const float here = depth(row, col);
  const auto along = [&](int d_row, int d_col) {
    float least = std::numeric_limits<float>::infinity();
    for (const int sign : {-1, 1}) {
      const int r = row + sign * d_row, c = col + sign * d_col;
      if (r < 0 || c < 0 || r >= depth.rows || c >= depth.cols) continue;
      least = std::min(least, std::abs(depth(r, c) - here));
    }
    return std::isfinite(least) ? least : 0.0F;
  };
  const float across = along(0, 1), down = along(1, 0);
  return std::sqrt(across * across + down * down);
}

Sight DepthImage::look(const Eigen::Vector2f& pixel, const Eigen::Vector3f& point, const Eigen::Vector3f& normal,
                       float radius, const DepthParams& params, float thickness) const {
  const float u = (pixel.x() + 0.5F) / cell_size, v = (pixel.y() + 0.5F) / cell_size;
  if (!(u >= 0 && v >= 0 && u < static_cast<float>(depth.cols) && v < static_cast<float>(depth.rows))) {
    return {};
  }
  const int row = static_cast<int>(v), col = static_cast<int>(u);
  if (radius < 0 && empty_space && !empty_space->confirms(point)) return {Visibility::kAbsent, -1};
  radius = std::abs(radius);
  const float distance = point.norm(), behind = distance - depth(row, col);
  const float share = static_cast<float>(params.depth_tolerance) * distance;
  const bool ball = normal.isZero();
  const float slack = (ball ? kBallThickness : kThickness) * radius + kSlabDeviations * thickness;
  float allowed = share + slack;
  bool uncovered = false;
  if (behind > allowed) {
    // On a slanted surface thickness and the extent of a cell are more along the ray. Both the point's own surface and
    // the one that is seen must be slanted, else a wall would not hide what stands edge-on behind it.
    const float cell = cell_size * pixel_angle * distance;
    const float seen_tangent = slope(row, col) / cell;
    const float seen = kCellSlack * cell * seen_tangent + slack * std::sqrt(1 + seen_tangent * seen_tangent);
    const float cosine = ball ? 1.0F : std::min(1.0F, std::max(kMinCosine, std::abs(normal.dot(point)) / distance));
    const float own = kCellSlack * cell * std::sqrt(1 - cosine * cosine) / cosine + slack / cosine;
    allowed = share + std::min(own, seen);
    if (!(behind <= allowed)) {
      const float tangent = std::min(kMaxTangent, std::sqrt(1 - cosine * cosine) / cosine);
      const float range =
          distance * std::min(kMaxRangeShare, std::max(kRangeShare, (share + slack / cosine) / distance));
      uncovered = empty_space && empty_space->uncovers(point, depth(row, col), range, tangent);
      if (!uncovered) return {Visibility::kHidden, supportOf(behind, allowed)};
    }
  }
  // A point that is there was splatted itself. So only one that is nearer than all splats can be absent.
  if (behind < -share - slack && empty_space && empty_space->contains(point)) {
    return {Visibility::kAbsent, -1};
  }
  return {edge(row, col) != 0 ? Visibility::kEdge : Visibility::kVisible, uncovered ? 1 : supportOf(behind, allowed)};
}

DepthSplatter::DepthSplatter(const Camera& camera, const Eigen::Isometry3f& camera_from_map, const DepthParams& params,
                             std::shared_ptr<const EmptySpace> empty_space)
    : camera_(&camera), camera_from_map_(camera_from_map), params_(params), empty_space_(std::move(empty_space)) {
  params.check();
  params_.depth_cell_size = params.cellSize(camera.intrinsics());
  const auto cells = [&](int pixels) { return static_cast<int>(std::ceil(pixels / params_.depth_cell_size)); };
  inverse_ = cv::Mat1f(cells(camera.intrinsics().height), cells(camera.intrinsics().width), 0.0F);
}

void DepthSplatter::splat(const Eigen::Vector3f& point, const Eigen::Vector3f& normal, float radius) {
  const auto at = camera_->linearizeUnbounded(point);
  if (!at) return;
  const auto scale = static_cast<float>(1 / params_.depth_cell_size);
  const Eigen::Matrix<float, 2, 3> jacobian = at->jacobian * scale;
  const float distance = point.norm(), r = std::min(radius, kMaxShare * distance);
  const Eigen::Vector3f ray = point / distance;
  const Eigen::Matrix2f spread = jacobian * jacobian.transpose();
  // The disc's outline: r^2 J (I - n n^T) J^T. Without a plane, a disc that faces the camera.
  Eigen::Matrix2f shape = r * r * spread;
  const float cosine = normal.dot(ray);
  const bool plane = std::abs(cosine) > 1e-3F;
  if (!normal.isZero()) {
    const Eigen::Vector2f toward = r * (jacobian * normal);
    shape -= toward * toward.transpose();
  }
  shape.diagonal().array() += kLowPass * kLowPass;
  const float largest = shape.diagonal().maxCoeff();
  if (!(largest > 0 && std::isfinite(largest))) return;
  if (largest > kMaxSplat * kMaxSplat) shape *= kMaxSplat * kMaxSplat / largest;
  const Eigen::Matrix2f inverse = shape.inverse();
  Ellipse e{};
  e.u = (at->pixel.x() + 0.5F) * scale - 0.5F;
  e.v = (at->pixel.y() + 0.5F) * scale - 0.5F;
  e.a = inverse(0, 0), e.b = inverse(0, 1), e.c = inverse(1, 1);
  e.half_width = std::sqrt(shape(0, 0)), e.half_height = std::sqrt(shape(1, 1));
  if (e.u + e.half_width < -0.5F || e.v + e.half_height < -0.5F) return;
  if (e.u - e.half_width > static_cast<float>(inverse_.cols) || e.v - e.half_height > static_cast<float>(inverse_.rows))
    return;
  e.inverse = 1 / distance;
  // Not beyond the disc: a plane that noise has tilted errs the more the farther it is followed.
  const float extent = plane ? r * std::sqrt(std::max(0.0F, 1 - cosine * cosine)) : 0;
  e.nearest = 1 / (distance - extent), e.farthest = 1 / (distance + extent);
  if (plane) {
    // 1 / distance = n.ray / n.point; a pixel moves the ray by J^T (J J^T)^-1 / distance.
    const Eigen::Vector2f slope = spread.inverse() * (jacobian * normal) / (cosine * distance * distance);
    e.du = slope.x(), e.dv = slope.y();
  }
  if (std::isfinite(e.du + e.dv) && std::isfinite(e.u + e.v) && std::isfinite(e.a * e.b * e.c)) fill(e, inverse_);
}

void DepthSplatter::add(PointsRef points, const Surfels& surfels) {
  const auto reach = static_cast<float>(params_.reach() * 1.1), reach2 = reach * reach;
  const Eigen::Matrix3f rotation = camera_from_map_.linear();
  const Eigen::Vector3f translation = camera_from_map_.translation();
  for (Eigen::Index i = 0; i < points.cols(); ++i) {
    const Eigen::Vector3f point = rotation * surfels.onSurface(i, points.col(i)) + translation;
    const float radius = std::abs(surfels.radii[i]);
    const bool moves = surfels.radii[i] < 0;
    if (moves && !empty_space_) continue;
    if (!camera_->mayShow(point, radius) || !(point.squaredNorm() < reach2)) continue;
    if (empty_space_ && (moves ? !empty_space_->confirms(point) : empty_space_->contains(point))) continue;
    splat(point, rotation * surfels.normals.col(i), radius);
  }
}

DepthImage DepthSplatter::finish() const {
  const cv::Mat1f closed = closeHoles(inverse_);
  DepthImage image;
  image.empty_space = empty_space_;
  image.cell_size = static_cast<float>(params_.depth_cell_size);
  image.pixel_angle = static_cast<float>(camera_->pixelAngle());
  image.edge = findEdges(closed, static_cast<int>(std::ceil(params_.depth_edge_guard / params_.depth_cell_size)));
  image.depth.create(closed.size());
  std::transform(closed.begin(), closed.end(), image.depth.begin(),
                 [](float w) { return w > 0 ? 1 / w : std::numeric_limits<float>::infinity(); });
  return image;
}

}  // namespace cloud_colorizer
