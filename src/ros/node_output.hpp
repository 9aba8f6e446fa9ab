// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause

/// What the node publishes. Safe to use from several threads.
#pragma once

#include <diagnostic_updater/diagnostic_updater.h>
#include <nav_msgs/Path.h>
#include <ros/node_handle.h>
#include <tf2_ros/static_transform_broadcaster.h>

#include <Eigen/Core>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "cloud_colorizer/recording/recording.hpp"
#include "cloud_colorizer/ros/params.hpp"
#include "ros/topic_monitor.hpp"

namespace cloud_colorizer {

/// A line of the core's log on the ROS console.
void logLine(LogLevel level, const std::string& text);

/// What is known about recording, for status and diagnostics.
struct RecordingState {
  std::string stage;  ///< idle, recording or paused
  std::string directory;
  std::size_t points = 0, views = 0, pending = 0;
  CollectorStats stats;
  std::vector<TopicMonitor::Report> topics;
};

/// What is known about colouring.
struct JobStatus {
  bool running = false;
  Progress progress;
  std::size_t num_colored = 0;
  std::string message;  ///< result of the last job
};

class NodeOutput {
 public:
  NodeOutput(const ros::NodeHandle& node, const ros::NodeHandle& private_node, const NodeParams& params);

  void publishStatus(const RecordingState& recording, const JobStatus& job);
  void publishPath(nav_msgs::Path path);
  /// Positions relative to `origin`.
  void publishPreview(const Cloud& cloud, const Eigen::Vector3d& origin);
  /// The coloured map and its preview, thinned to what a message and rviz can bear.
  void publishMap(const Recording& recording, const Params& params);

 private:
  /// The frame of positions relative to `origin`, announced on /tf_static where it is not the map frame itself.
  std::string frameFor(const Eigen::Vector3d& origin);
  void diagnose(diagnostic_updater::DiagnosticStatusWrapper& status);

  NodeParams params_;
  ros::Publisher map_, preview_, path_, status_;
  std::mutex mutex_;
  tf2_ros::StaticTransformBroadcaster broadcaster_;
  std::unique_ptr<Eigen::Vector3d> announced_;
  RecordingState recording_;
  JobStatus job_;
  diagnostic_updater::Updater diagnostics_;
};

}  // namespace cloud_colorizer
