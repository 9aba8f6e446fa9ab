// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause
#include "ros/livox.hpp"

#include <ros/serialization.h>

#include <boost/make_shared.hpp>

namespace cloud_colorizer {
namespace {

using sensor_msgs::PointField;

constexpr std::uint32_t kPointSize = 19;           // bytes
constexpr std::uint32_t kBetween = 8 + 4 + 1 + 3;  // bytes of timebase, point_num, lidar_id and rsvd

PointField field(const char* name, std::uint32_t offset, std::uint8_t type) {
  PointField result;
  result.name = name;
  result.offset = offset;
  result.datatype = type;
  result.count = 1;
  return result;
}

}  // namespace

bool isLivoxType(const std::string& type) {
  return type == "livox_ros_driver/CustomMsg" || type == "livox_ros_driver2/CustomMsg";
}

sensor_msgs::PointCloud2Ptr cloudFromLivox(std::vector<std::uint8_t>& message) {
  auto cloud = boost::make_shared<sensor_msgs::PointCloud2>();
  std::uint32_t num_points = 0;
  ros::serialization::IStream stream(message.data(), static_cast<std::uint32_t>(message.size()));
  try {
    stream.next(cloud->header);
    stream.advance(kBetween);
    stream.next(num_points);
  } catch (const ros::Exception&) {
    return cloud;
  }
  if (num_points > stream.getLength() / kPointSize) return cloud;
  cloud->fields = {field("x", 4, PointField::FLOAT32),         field("y", 8, PointField::FLOAT32),
                   field("z", 12, PointField::FLOAT32),        field("intensity", 16, PointField::UINT8),
                   field("tag", 17, PointField::UINT8),        field("line", 18, PointField::UINT8),
                   field("offset_time", 0, PointField::UINT32)};
  cloud->height = 1;
  cloud->width = num_points;
  cloud->point_step = kPointSize;
  cloud->row_step = num_points * kPointSize;
  cloud->data.assign(stream.getData(), stream.getData() + cloud->row_step);
  return cloud;
}

}  // namespace cloud_colorizer
