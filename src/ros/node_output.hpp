// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause

/// What the node publishes. Safe to use from several threads.
#pragma once

#include <diagnostic_updater/diagnostic_updater.h>
#include <nav_msgs/Path.h>
#include <ros/node_handle.h>
#include <tf2_ros/static_transform_broadcaster.h>

#include <Eigen/Core>
#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "cloud_colorizer/recording/recording.hpp"
#include "cloud_colorizer/ros/params.hpp"
#include "ros/map_job.hpp"
#include "ros/node_log.hpp"
#include "ros/recording_session.hpp"
#include "ros/topic_monitor.hpp"

namespace cloud_colorizer {

/// What the node knows about itself, for status and diagnostics.
struct NodeState {
  std::string stage;  ///< idle, recording, paused or error
  std::string directory;
  SessionState session;
  JobStatus job;
  std::vector<TopicMonitor::Report> topics;
  std::map<std::string, ErrorLog::Row> errors;
};

class NodeOutput {
 public:
  NodeOutput(const ros::NodeHandle& node, const ros::NodeHandle& private_node, const NodeParams& params);

  void publishStatus(const NodeState& state);
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
  std::mutex frame_mutex_;  ///< the next two
  tf2_ros::StaticTransformBroadcaster broadcaster_;
  std::unique_ptr<Eigen::Vector3d> announced_;
  std::mutex diagnostics_mutex_;  ///< what follows
  NodeState state_;
  diagnostic_updater::Updater diagnostics_;
};

}  // namespace cloud_colorizer
