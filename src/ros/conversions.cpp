// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause

#include "cloud_colorizer/ros/conversions.hpp"

#include "cloud/point_cloud2.hpp"

namespace cloud_colorizer {

Cloud cloudFromMessage(const sensor_msgs::PointCloud2& message) {
  return cloudFrom(message);
}

void appendToMessage(const Cloud& cloud, sensor_msgs::PointCloud2& message) {
  appendCloud(cloud, message);
}

}  // namespace cloud_colorizer
