// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause
#include "ros/transform_reader.hpp"

#include <algorithm>
#include <utility>

#include "ros/moving_frame.hpp"
#include "ros/transform_buffer.hpp"

namespace cloud_colorizer {
namespace {

tf2_msgs::TFMessage messageOf(const geometry_msgs::TransformStamped& transform) {
  tf2_msgs::TFMessage message;
  message.transforms.push_back(transform);
  return message;
}

}  // namespace

TransformReader::TransformReader(std::unique_ptr<rosbag::View> view, const Rig& rig, double lead, Collector& collector,
                                 ClockWatch& clocks)
    : view_(std::move(view)),
      next_(view_->begin()),
      rig_(rig),
      pose_(rig.poses.begin()),
      lead_(lead),
      collector_(collector),
      clocks_(clocks) {}

void TransformReader::giveFixed(std::vector<geometry_msgs::TransformStamped> fixed,
                                const std::vector<geometry_msgs::TransformStamped>& once) {
  fixed.insert(fixed.end(), once.begin(), once.end());
  for (const auto& transform : once) known_.insert(transform.child_frame_id);
  if (!rig_.poses.empty()) {
    known_.insert(rig_.base_frame);
    fixed = rootedAt(rig_.base_frame, fixed, known_);
  }
  tf2_msgs::TFMessage message;
  message.transforms = std::move(fixed);
  collector_.addTransforms(message, true);
}

void TransformReader::givePosesTo(ros::Time stamp) {
  if (stamp.isZero() || stamp > ros::TIME_MAX - lead_) return;
  if (stamp + ros::Duration(1) < last_stamp_) pose_ = rig_.poses.begin();
  last_stamp_ = stamp;
  for (; pose_ != rig_.poses.end() && pose_->header.stamp <= stamp + lead_; ++pose_) {
    collector_.addTransforms(messageOf(*pose_), false);
  }
}

void TransformReader::readTo(ros::Time time) {
  if (time > ros::TIME_MAX - lead_) time = ros::TIME_MAX - lead_;
  for (; next_ != view_->end() && next_->getTime() <= time + lead_; ++next_) {
    const tf2_msgs::TFMessage message = read();
    if (next_->getTime() > time && stepsBack(message)) return;
    for (const auto& transform : message.transforms) {
      last_[transform.child_frame_id] = transform.header.stamp;
      clocks_.add(kTfTopics.front(), next_->getTime(), transform.header.stamp);
    }
    collector_.addTransforms(message, false);
  }
}

tf2_msgs::TFMessage TransformReader::read() const {
  if (next_->getTopic() == rig_.odometry) return messageOf(transformOf(*next_, rig_.base_frame));
  const auto message = next_->instantiate<tf2_msgs::TFMessage>();
  tf2_msgs::TFMessage result = message ? *message : tf2_msgs::TFMessage();
  auto& transforms = result.transforms;
  const auto is_given = [this](const geometry_msgs::TransformStamped& transform) {
    return known_.count(withoutSlash(transform.child_frame_id)) != 0;
  };
  transforms.erase(std::remove_if(transforms.begin(), transforms.end(), is_given), transforms.end());
  return result;
}

bool TransformReader::stepsBack(const tf2_msgs::TFMessage& message) const {
  for (const auto& transform : message.transforms) {
    const auto last = last_.find(transform.child_frame_id);
    if (last != last_.end() && transform.header.stamp < last->second) return true;
  }
  return false;
}

}  // namespace cloud_colorizer
