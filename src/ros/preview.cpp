// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause

#include "ros/preview.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>

namespace cloud_colorizer {
namespace {

constexpr Eigen::Index kMaxPointsOfCloud = 20000;
constexpr float kCell = 16;              // px, of the coarse depth image
constexpr float kDepthTolerance = 1.1F;  // of the nearest depth in the cell
constexpr float kDepthMargin = 0.5F;     // m

struct Seen {
  std::size_t point;
  Eigen::Vector2f pixel;
  float depth;
};

/// The nearest depth in every cell.
cv::Mat1f coarseDepth(const std::vector<Seen>& seen, const Intrinsics& intrinsics) {
  const int rows = static_cast<int>(static_cast<float>(intrinsics.height) / kCell) + 1;
  const int cols = static_cast<int>(static_cast<float>(intrinsics.width) / kCell) + 1;
  cv::Mat1f depth(rows, cols, std::numeric_limits<float>::max());
  for (const Seen& s : seen) {
    const int u = static_cast<int>((s.pixel.x() + 0.5F) / kCell), v = static_cast<int>((s.pixel.y() + 0.5F) / kCell);
    float& cell = depth(std::clamp(v, 0, rows - 1), std::clamp(u, 0, cols - 1));
    cell = std::min(cell, s.depth);
  }
  return depth;
}

float packRgb(const Eigen::Vector3f& bgr) {
  const auto byte = [](float value) { return static_cast<std::uint32_t>(std::clamp(std::lround(value), 0L, 255L)); };
  const std::uint32_t packed = byte(bgr[2]) << 16U | byte(bgr[1]) << 8U | byte(bgr[0]);
  float result;
  std::memcpy(&result, &packed, sizeof(result));
  return result;
}

}  // namespace

std::uint64_t voxelKey(const Eigen::Vector3d& position, double voxel_size) {
  std::uint64_t key = 0;
  for (int axis = 0; axis < 3; ++axis) {
    const auto cell = static_cast<std::int64_t>(std::floor(position[axis] / voxel_size));
    key = key << 21U | (static_cast<std::uint64_t>(cell) & 0x1FFFFFU);
  }
  return key;
}

RunningPreview::RunningPreview(double voxel_size, std::size_t max_points)
    : voxel_size_(voxel_size), max_points_(max_points) {}

void RunningPreview::clear() {
  points_.clear();
  index_.clear();
  oldest_ = 0;
}

void RunningPreview::addCloud(const Cloud& cloud, const Eigen::Isometry3d& map_from_sensor, double min_range,
                              double max_range) {
  const Eigen::Index step = cloud.positions.cols() / kMaxPointsOfCloud + 1;
  for (Eigen::Index i = 0; i < cloud.positions.cols(); i += step) {
    const double range = cloud.positions.col(i).norm();
    if (!(range >= min_range && range <= max_range)) continue;  // false for NaN
    const Eigen::Vector3d position = map_from_sensor * cloud.positions.col(i);
    const std::uint64_t key = voxelKey(position, voxel_size_);
    const bool full = points_.size() >= max_points_;
    if (!index_.emplace(key, full ? oldest_ : points_.size()).second) continue;
    Point point;
    point.position = position;
    point.key = key;
    if (!full) {
      points_.push_back(point);
      continue;
    }
    index_.erase(points_[oldest_].key);
    points_[oldest_] = point;
    oldest_ = (oldest_ + 1) % max_points_;
  }
}

void RunningPreview::addView(const Camera& camera, const Eigen::Isometry3d& map_from_camera, const cv::Mat3b& image,
                             double max_distance) {
  const Eigen::Isometry3d camera_from_map = map_from_camera.inverse();
  std::vector<Seen> seen;
  for (std::size_t i = 0; i < points_.size(); ++i) {
    if ((points_[i].position - map_from_camera.translation()).squaredNorm() > max_distance * max_distance) continue;
    const Eigen::Vector3f point = (camera_from_map * points_[i].position).cast<float>();
    if (const auto pixel = camera.project(point)) seen.push_back({i, *pixel, point.z()});
  }
  const Intrinsics& intrinsics = camera.intrinsics();
  const cv::Mat1f depth = coarseDepth(seen, intrinsics);
  const float scale_x = static_cast<float>(image.cols) / static_cast<float>(intrinsics.width);
  const float scale_y = static_cast<float>(image.rows) / static_cast<float>(intrinsics.height);
  for (const Seen& s : seen) {
    const int cell_u = std::clamp(static_cast<int>((s.pixel.x() + 0.5F) / kCell), 0, depth.cols - 1);
    const int cell_v = std::clamp(static_cast<int>((s.pixel.y() + 0.5F) / kCell), 0, depth.rows - 1);
    if (s.depth > depth(cell_v, cell_u) * kDepthTolerance + kDepthMargin) continue;
    const int u = std::clamp(static_cast<int>((s.pixel.x() + 0.5F) * scale_x), 0, image.cols - 1);
    const int v = std::clamp(static_cast<int>((s.pixel.y() + 0.5F) * scale_y), 0, image.rows - 1);
    const cv::Vec3b& color = image(v, u);
    const Eigen::Vector3f value(color[0], color[1], color[2]);
    Point& point = points_[s.point];
    if (point.count == std::numeric_limits<std::uint16_t>::max()) continue;
    ++point.count;
    const Eigen::Vector3f before = value - point.mean;
    point.mean += before / static_cast<float>(point.count);
    point.squares += before.dot(value - point.mean);  // Welford
  }
}

Cloud RunningPreview::cloud(const Eigen::Vector3d& origin) const {
  Cloud result;
  result.fields = {
      {"rgb", FieldType::kFloat32, 1}, {"view_count", FieldType::kUint16, 1}, {"color_stddev", FieldType::kFloat32, 1}};
  const std::size_t record = recordSize(result.fields);
  result.positions.resize(3, static_cast<Eigen::Index>(points_.size()));
  result.records.resize(points_.size() * record);
  std::uint8_t* out = result.records.data();
  for (std::size_t i = 0; i < points_.size(); ++i, out += record) {
    const Point& point = points_[i];
    result.positions.col(static_cast<Eigen::Index>(i)) = point.position - origin;
    const float rgb = packRgb(point.count > 0 ? point.mean : Eigen::Vector3f::Constant(128));
    const float stddev = point.count > 0 ? std::sqrt(point.squares / (3.0F * static_cast<float>(point.count))) : 0.0F;
    std::memcpy(out, &rgb, 4);
    std::memcpy(out + 4, &point.count, 2);
    std::memcpy(out + 6, &stddev, 4);
  }
  return result;
}

Cloud selectPoints(const Cloud& cloud, const std::vector<Eigen::Index>& indices) {
  const std::size_t record = recordSize(cloud.fields);
  Cloud result;
  result.fields = cloud.fields;
  result.positions.resize(3, static_cast<Eigen::Index>(indices.size()));
  result.records.resize(indices.size() * record);
  for (std::size_t i = 0; i < indices.size(); ++i) {
    result.positions.col(static_cast<Eigen::Index>(i)) = cloud.positions.col(indices[i]);
    if (record == 0) continue;
    std::memcpy(result.records.data() + i * record,
                cloud.records.data() + static_cast<std::size_t>(indices[i]) * record, record);
  }
  return result;
}

VoxelThinner::VoxelThinner(double voxel_size, std::size_t max_points)
    : voxel_size_(voxel_size), max_points_(max_points) {}

void VoxelThinner::add(const Cloud& cloud) {
  keepFirsts(cloud);
  while (positions_.size() > max_points_) {
    voxel_size_ *= 2;
    const Cloud all = this->cloud();
    taken_.clear();
    positions_.clear();
    records_.clear();
    keepFirsts(all);
  }
}

Cloud VoxelThinner::cloud() const {
  Cloud result;
  result.fields = fields_;
  result.positions.resize(3, static_cast<Eigen::Index>(positions_.size()));
  for (std::size_t i = 0; i < positions_.size(); ++i) {
    result.positions.col(static_cast<Eigen::Index>(i)) = positions_[i];
  }
  result.records = records_;
  return result;
}

void VoxelThinner::keepFirsts(const Cloud& from) {
  fields_ = from.fields;
  const auto record = static_cast<std::ptrdiff_t>(recordSize(fields_));
  for (Eigen::Index i = 0; i < from.positions.cols(); ++i) {
    if (!taken_.insert(voxelKey(from.positions.col(i), voxel_size_)).second) continue;
    positions_.push_back(from.positions.col(i));
    const auto first = from.records.begin() + i * record;
    records_.insert(records_.end(), first, first + record);
  }
}

}  // namespace cloud_colorizer
