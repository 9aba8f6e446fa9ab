// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause

/// Clouds thin enough to look at: the preview while recording, and a thinned copy of a coloured map.
#pragma once

#include <Eigen/Geometry>
#include <cstdint>
#include <opencv2/core.hpp>
#include <unordered_map>
#include <unordered_set>
#include <vector>

#include "cloud_colorizer/camera/camera.hpp"
#include "cloud_colorizer/cloud/cloud.hpp"

namespace cloud_colorizer {

/// colored_map_preview has one point a voxel [m], and no more than a display shows fluently: the newest.
constexpr double kPreviewVoxelSize = 0.25;
constexpr std::size_t kMaxPreviewPoints = 500000;

/// Index of the voxel of a position, 21 bits an axis; positions 2^21 voxels apart share one.
std::uint64_t voxelKey(const Eigen::Vector3d& position, double voxel_size);

/// One point a voxel with the running mean of the colours that the newest views gave it. Memory is bounded: beyond
/// max_points the oldest points go. Occlusion is tested coarsely; it is a preview.
class RunningPreview {
 public:
  RunningPreview(double voxel_size, std::size_t max_points);

  /// Takes up to about 20,000 points of the cloud.
  void addCloud(const Cloud& cloud, const Eigen::Isometry3d& map_from_sensor, double min_range, double max_range);
  /// `image` is BGR and may be smaller than the camera's; points up to `max_distance` [m] are coloured.
  void addView(const Camera& camera, const Eigen::Isometry3d& map_from_camera, const cv::Mat3b& image,
               double max_distance);
  void clear();

  std::size_t numPoints() const { return points_.size(); }
  /// Fields rgb, view_count, color_stddev; positions minus `origin`. Points without a colour are grey.
  Cloud cloud(const Eigen::Vector3d& origin) const;

 private:
  struct Point {
    Eigen::Vector3d position;
    std::uint64_t key = 0;
    Eigen::Vector3f mean = Eigen::Vector3f::Zero();  ///< blue, green, red
    float squares = 0;                               ///< sum of squared differences from the mean, all channels
    std::uint16_t count = 0;
  };

  double voxel_size_;
  std::size_t max_points_;
  std::vector<Point> points_;
  std::size_t oldest_ = 0;
  std::unordered_map<std::uint64_t, std::size_t> index_;
};

/// Keeps the first point of every voxel; doubles the voxel until no more than max_points are left.
class VoxelThinner {
 public:
  VoxelThinner(double voxel_size, std::size_t max_points);
  void add(const Cloud& cloud);
  Cloud cloud() const;
  double voxelSize() const { return voxel_size_; }

 private:
  void keepFirsts(const Cloud& from);

  double voxel_size_;
  std::size_t max_points_;
  std::vector<Field> fields_;
  std::vector<Eigen::Vector3d> positions_;
  std::vector<std::uint8_t> records_;
  std::unordered_set<std::uint64_t> taken_;
};

/// The points of `cloud` with the given indices.
Cloud selectPoints(const Cloud& cloud, const std::vector<Eigen::Index>& indices);

}  // namespace cloud_colorizer
