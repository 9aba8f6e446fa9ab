// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause

/// The transforms of a bag that hold for all of it.
#pragma once

#include <geometry_msgs/TransformStamped.h>
#include <rosbag/view.h>

#include <vector>

namespace cloud_colorizer {

/// All of the messages, without leading slashes.
std::vector<geometry_msgs::TransformStamped> readTransforms(rosbag::View& view);

/// Of the transforms in the first seconds of a bag's /tf those that come once there, not again in its last seconds, and
/// not with a frame that moves: converters by hand write fixed ones so.
std::vector<geometry_msgs::TransformStamped> givenOnce(const std::vector<geometry_msgs::TransformStamped>& first,
                                                       const std::vector<geometry_msgs::TransformStamped>& last);

}  // namespace cloud_colorizer
