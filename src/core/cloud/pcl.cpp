// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause
#include "cloud_colorizer/cloud/pcl.hpp"

#include "cloud/point_cloud2.hpp"

namespace cloud_colorizer {

Cloud toCloud(const pcl::PCLPointCloud2& points) {
  return cloudFrom(points);
}

pcl::PCLPointCloud2 toPcl(const Cloud& cloud) {
  pcl::PCLPointCloud2 points;
  appendCloud(cloud, points);
  return points;
}

}  // namespace cloud_colorizer
