// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause

/// livox_ros_driver/CustomMsg and livox_ros_driver2/CustomMsg, without their packages.
#pragma once

#include <ros/serialization.h>
#include <sensor_msgs/PointCloud2.h>

#include <cstdint>
#include <string>
#include <vector>

namespace cloud_colorizer {

bool isLivoxType(const std::string& type);

/// From a serialized message; fields x, y, z, intensity (its reflectivity), tag, line, offset_time [ns]. Both drivers
/// lay it out alike:
///   Header header; uint64 timebase; uint32 point_num; uint8 lidar_id; uint8[3] rsvd; CustomPoint[] points
///   CustomPoint: uint32 offset_time; float32 x, y, z; uint8 reflectivity, tag, line
/// One that is cut off has no points and no fields.
sensor_msgs::PointCloud2Ptr cloudFromLivox(std::vector<std::uint8_t>& message);

/// Of a rosbag::MessageInstance or a topic_tools::ShapeShifter: a cloud of either kind. Of another type: null of a
/// bag's message; of a shape shifter what it throws.
template <class Message>
sensor_msgs::PointCloud2ConstPtr cloudOf(const Message& message) {
  if (!isLivoxType(message.getDataType())) return message.template instantiate<sensor_msgs::PointCloud2>();
  std::vector<std::uint8_t> bytes(message.size());
  ros::serialization::OStream stream(bytes.data(), message.size());
  message.write(stream);
  return cloudFromLivox(bytes);
}

}  // namespace cloud_colorizer
