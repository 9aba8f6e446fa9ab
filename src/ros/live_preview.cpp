// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause
#include "ros/live_preview.hpp"

#include <tf2_eigen/tf2_eigen.h>

#include <opencv2/imgcodecs.hpp>
#include <utility>

namespace cloud_colorizer {
namespace {

constexpr std::size_t kMaxPathPoses = 100000;

}  // namespace

LivePreview::LivePreview(const AllParams& params, NodeOutput& output, ErrorLog& errors)
    : params_(params),
      output_(output),
      errors_(errors),
      preview_(kPreviewVoxelSize, kMaxPreviewPoints),
      newest_views_(params.node.collector.cameras.size()) {}

void LivePreview::addCloud(const Cloud& cloud, const Eigen::Isometry3d& map_from_sensor) {
  const RecordParams& record = params_.core.record;
  const std::lock_guard<std::mutex> lock(mutex_);
  preview_.addCloud(cloud, map_from_sensor, record.min_range, record.max_range);
  changed_ = true;
}

void LivePreview::addView(std::size_t camera, const View& view, const Intrinsics& intrinsics,
                          const SharedBytes& bytes) {
  const std::lock_guard<std::mutex> lock(mutex_);
  newest_views_[camera] = {view, intrinsics, bytes};
  if (camera != 0) return;
  path_.poses.emplace_back();
  path_.poses.back().header.stamp.fromSec(view.stamp);
  path_.poses.back().header.frame_id = params_.node.collector.map_frame;
  path_.poses.back().pose = tf2::toMsg(view.map_from_camera);
  if (path_.poses.size() > kMaxPathPoses) {
    path_.poses.erase(path_.poses.begin(), path_.poses.begin() + kMaxPathPoses / 10);
  }
}

void LivePreview::color(NewestView& newest) {
  const SharedBytes bytes = std::exchange(newest.bytes, nullptr);
  if (!bytes) return;
  const cv::Mat3b image = cv::imdecode(*bytes, cv::IMREAD_REDUCED_COLOR_4);
  if (image.empty()) return;
  const Camera camera = Camera(newest.intrinsics).whileMoving(newest.view.readout_motion);
  preview_.addView(camera, newest.view.map_from_camera, image, params_.core.depth.reach(params_.core.record.max_range));
}

void LivePreview::publish(const Eigen::Vector3d& origin) {
  const std::lock_guard<std::mutex> lock(mutex_);
  if (!changed_) return;
  changed_ = false;
  // An image that cannot be decoded costs its own colours only.
  for (NewestView& newest : newest_views_) errors_.guard("preview", [&] { color(newest); });
  output_.publishPreview(preview_.cloud(origin), origin);
  output_.publishPath(path_);
}

void LivePreview::clear() {
  const std::lock_guard<std::mutex> lock(mutex_);
  preview_.clear();
  path_.poses.clear();
  for (NewestView& newest : newest_views_) newest = {};
  changed_ = true;
}

}  // namespace cloud_colorizer
