// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause

/// Clouds of PCL and ours. Needs the headers of PCL (pcl_common), 1.10 or newer.
#pragma once

#include <pcl/PCLPointCloud2.h>
#include <pcl/conversions.h>
#include <pcl/point_cloud.h>

#include "cloud_colorizer/cloud/cloud.hpp"

namespace cloud_colorizer {

/// Positions and all fields, of any type that sensor_msgs/PointField knows; NaN passes through. Throws
/// std::invalid_argument, with field or size, for a missing x, y or z, a field twice, another type, a million
/// numbers a point or more, or sizes that contradict each other.
Cloud toCloud(const pcl::PCLPointCloud2& points);

template <class PointT>
Cloud toCloud(const pcl::PointCloud<PointT>& points) {
  pcl::PCLPointCloud2 blob;
  pcl::toPCLPointCloud2(points, blob);
  return toCloud(blob);
}

/// x, y, z as FLOAT32 (what is far from zero loses digits: subtract an origin first), then all fields, packed,
/// height 1. Throws std::invalid_argument beyond 4 GB.
pcl::PCLPointCloud2 toPcl(const Cloud& cloud);

/// Those fields that PointT has, such as the rgb of pcl::PointXYZRGB; PCL warns of a field that the cloud has not.
template <class PointT>
pcl::PointCloud<PointT> toPcl(const Cloud& cloud) {
  pcl::PointCloud<PointT> points;
  pcl::fromPCLPointCloud2(toPcl(cloud), points);
  return points;
}

}  // namespace cloud_colorizer
