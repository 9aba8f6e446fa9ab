// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause
#include "ros/fixed_frames.hpp"

#include <tf2_msgs/TFMessage.h>

#include <algorithm>
#include <map>
#include <string>

#include "ros/transform_buffer.hpp"

namespace cloud_colorizer {
namespace {

constexpr std::size_t kMoving = 5;  // transforms of a frame that moves in those seconds, at least

}  // namespace

using geometry_msgs::TransformStamped;

std::vector<TransformStamped> readTransforms(rosbag::View& view) {
  std::vector<TransformStamped> all;
  for (const rosbag::MessageInstance& message : view) {
    const auto transforms = message.instantiate<tf2_msgs::TFMessage>();
    if (!transforms) continue;
    for (TransformStamped transform : transforms->transforms) {
      transform.child_frame_id = withoutSlash(transform.child_frame_id);
      transform.header.frame_id = withoutSlash(transform.header.frame_id);
      all.push_back(transform);
    }
  }
  return all;
}

std::vector<TransformStamped> givenOnce(const std::vector<TransformStamped>& first,
                                        const std::vector<TransformStamped>& last) {
  std::map<std::string, std::size_t> counts;
  for (const TransformStamped& transform : first) ++counts[transform.child_frame_id];
  const bool any_moves =
      std::any_of(counts.begin(), counts.end(), [](const auto& count) { return count.second >= kMoving; });
  if (!any_moves) return {};  // too short, or of poses that come seldom
  for (const TransformStamped& transform : last) ++counts[transform.child_frame_id];
  std::vector<TransformStamped> once;
  std::copy_if(first.begin(), first.end(), std::back_inserter(once),
               [&](const TransformStamped& transform) { return counts.at(transform.child_frame_id) == 1; });
  return once;
}

}  // namespace cloud_colorizer
