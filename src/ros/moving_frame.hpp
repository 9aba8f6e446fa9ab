// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause

/// Poses of one frame from elsewhere than tf: odometry messages, or a file.
#pragma once

#include <rosbag/view.h>
#include <tf2_msgs/TFMessage.h>

#include <set>
#include <string>
#include <vector>

#include "exchange/trajectory_file.hpp"

namespace cloud_colorizer {

/// The pose of a nav_msgs/Odometry or geometry_msgs/PoseStamped as a transform. An empty `base_frame` is what the
/// message says, which may be empty.
geometry_msgs::TransformStamped transformOf(const rosbag::MessageInstance& message, const std::string& base_frame);

/// Whether tf tells of the frame whose pose the first odometry message gives; a look at the first messages is enough.
bool movesFrame(rosbag::View& odometry, rosbag::View& tf, const std::string& base_frame);

geometry_msgs::TransformStamped transformOf(const TrajectoryPose& pose, const std::string& map_frame,
                                            const std::string& base_frame);

/// Turns the fixed tree so that `root` is above what it hung from, as its pose in the map is given. `below` becomes the
/// frames that it hung from: other transforms to them contradict the poses.
std::vector<geometry_msgs::TransformStamped> rootedAt(const std::string& root,
                                                      const std::vector<geometry_msgs::TransformStamped>& fixed,
                                                      std::set<std::string>& below);

}  // namespace cloud_colorizer
