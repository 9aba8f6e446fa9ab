// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause
#include "ros/moving_frame.hpp"

#include <geometry_msgs/PoseStamped.h>
#include <nav_msgs/Odometry.h>
#include <tf2_eigen/tf2_eigen.h>

#include <map>

namespace cloud_colorizer {

using geometry_msgs::TransformStamped;

TransformStamped transformOf(const rosbag::MessageInstance& message, const std::string& base_frame) {
  TransformStamped transform;
  geometry_msgs::Pose pose;
  transform.child_frame_id = base_frame;
  if (const auto odometry = message.instantiate<nav_msgs::Odometry>()) {
    transform.header = odometry->header;
    pose = odometry->pose.pose;
    if (base_frame.empty()) transform.child_frame_id = odometry->child_frame_id;
  } else if (const auto stamped = message.instantiate<geometry_msgs::PoseStamped>()) {
    transform.header = stamped->header;
    pose = stamped->pose;
  }
  transform.transform.translation.x = pose.position.x;
  transform.transform.translation.y = pose.position.y;
  transform.transform.translation.z = pose.position.z;
  transform.transform.rotation = pose.orientation;
  return transform;
}

bool movesFrame(rosbag::View& odometry, rosbag::View& tf, const std::string& base_frame) {
  constexpr int kFirst = 1000;
  if (odometry.begin() == odometry.end()) return true;
  const std::string child = transformOf(*odometry.begin(), base_frame).child_frame_id;
  int count = 0;
  for (const rosbag::MessageInstance& message : tf) {
    const auto transforms = message.instantiate<tf2_msgs::TFMessage>();
    if (!transforms) continue;
    for (const auto& transform : transforms->transforms) {
      if (transform.child_frame_id == child) return true;
    }
    if (++count == kFirst) break;
  }
  return child.empty();
}

TransformStamped transformOf(const TrajectoryPose& pose, const std::string& map_frame, const std::string& base_frame) {
  TransformStamped transform = tf2::eigenToTransform(pose.map_from_base);
  if (pose.stamp) transform.header.stamp.fromNSec(static_cast<std::uint64_t>(*pose.stamp));
  transform.header.frame_id = map_frame;
  transform.child_frame_id = base_frame;
  return transform;
}

std::vector<TransformStamped> rootedAt(const std::string& root, const std::vector<TransformStamped>& fixed,
                                       std::set<std::string>& below) {
  std::map<std::string, TransformStamped> by_child;
  for (const TransformStamped& transform : fixed) by_child[transform.child_frame_id] = transform;
  std::vector<TransformStamped> way;  // from the root upwards
  for (auto up = by_child.find(root); up != by_child.end(); up = by_child.find(way.back().header.frame_id)) {
    way.push_back(up->second);
    by_child.erase(up);
  }
  for (const TransformStamped& up : way) {
    TransformStamped down = tf2::eigenToTransform(tf2::transformToEigen(up.transform).inverse());
    down.header.stamp = up.header.stamp;
    down.header.frame_id = up.child_frame_id;
    down.child_frame_id = up.header.frame_id;
    below.insert(down.child_frame_id);
    by_child[down.child_frame_id] = down;
  }
  std::vector<TransformStamped> result;
  result.reserve(by_child.size());
  for (const auto& entry : by_child) result.push_back(entry.second);
  return result;
}

}  // namespace cloud_colorizer
