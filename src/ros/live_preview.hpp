// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause

/// The preview and the camera's path while recording. Safe to use from several threads.
#pragma once

#include <nav_msgs/Path.h>

#include <mutex>
#include <vector>

#include "cloud_colorizer/ros/params.hpp"
#include "ros/node_log.hpp"
#include "ros/node_output.hpp"
#include "ros/preview.hpp"

namespace cloud_colorizer {

class LivePreview {
 public:
  LivePreview(const AllParams& params, NodeOutput& output, ErrorLog& errors);

  void addCloud(const Cloud& cloud, const Eigen::Isometry3d& map_from_sensor);
  void addView(std::size_t camera, const View& view, const Intrinsics& intrinsics, const SharedBytes& bytes);
  /// Where something came since the last time. Positions of the preview are relative to `origin`.
  void publish(const Eigen::Vector3d& origin);
  void clear();

 private:
  /// The newest view of a camera.
  struct NewestView {
    View view;
    Intrinsics intrinsics;
    SharedBytes bytes;  ///< null when it was used
  };
  void color(NewestView& newest);

  const AllParams params_;
  NodeOutput& output_;
  ErrorLog& errors_;
  std::mutex mutex_;  ///< what follows
  RunningPreview preview_;
  bool changed_ = false;
  std::vector<NewestView> newest_views_;
  nav_msgs::Path path_;
};

}  // namespace cloud_colorizer
