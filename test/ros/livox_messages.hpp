// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause

/// Messages as Livox' drivers send them, byte by byte.
#pragma once

#include <ros/serialization.h>
#include <std_msgs/Header.h>

#include <Eigen/Core>
#include <cstdint>
#include <vector>

namespace cloud_colorizer::testing_ros {

/// A CustomMsg; point i has the offset_time 1000 i ns, the reflectivity i, the tag 1 and the line 2.
inline std::vector<std::uint8_t> livoxMessage(const std_msgs::Header& header, const Eigen::Matrix3Xd& points) {
  const auto count = static_cast<std::uint32_t>(points.cols());
  std::vector<std::uint8_t> bytes(ros::serialization::serializationLength(header) + 20 + 19 * count);
  ros::serialization::OStream out(bytes.data(), static_cast<std::uint32_t>(bytes.size()));
  out.next(header);
  out.next(header.stamp.toNSec());
  out.next(count);
  for (int i = 0; i < 4; ++i) out.next(std::uint8_t{0});  // lidar_id and rsvd
  out.next(count);                                        // the length of the list
  for (std::uint32_t i = 0; i < count; ++i) {
    out.next(1000 * i);
    for (int axis = 0; axis < 3; ++axis) out.next(static_cast<float>(points(axis, i)));
    out.next(static_cast<std::uint8_t>(i));
    out.next(std::uint8_t{1});
    out.next(std::uint8_t{2});
  }
  return bytes;
}

}  // namespace cloud_colorizer::testing_ros
