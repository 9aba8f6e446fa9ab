// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause

/// Points for the parts of PCL that tests take as oracles.
#pragma once

#include <pcl/point_cloud.h>
#include <pcl/point_types.h>

#include "cloud_colorizer/base/types.hpp"

namespace cloud_colorizer::test {

inline pcl::PointCloud<pcl::PointXYZ>::Ptr pclPoints(const Points& points) {
  pcl::PointCloud<pcl::PointXYZ>::Ptr cloud(new pcl::PointCloud<pcl::PointXYZ>);
  for (Eigen::Index i = 0; i < points.cols(); ++i) {
    cloud->push_back(pcl::PointXYZ(points(0, i), points(1, i), points(2, i)));
  }
  return cloud;
}

}  // namespace cloud_colorizer::test
