// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause

/// COLMAP's text model (cameras.txt, images.txt): how other programs hand over cameras and poses.
#pragma once

#include <Eigen/Geometry>
#include <string>
#include <vector>

#include "cloud_colorizer/camera/camera.hpp"

namespace cloud_colorizer {

struct ColmapImage {
  std::size_t camera = 0;  ///< index into ColmapModel::cameras
  Eigen::Isometry3d map_from_camera = Eigen::Isometry3d::Identity();
  std::string name;  ///< file, relative to the image directory
};

/// Principal points are in our convention (pixel centres at integers): COLMAP's minus 0.5.
struct ColmapModel {
  std::vector<Intrinsics> cameras;
  std::vector<ColmapImage> images;  ///< by ascending image id
};

/// Camera models SIMPLE_PINHOLE, PINHOLE, SIMPLE_RADIAL, RADIAL, OPENCV, FULL_OPENCV, OPENCV_FISHEYE; throws
/// std::runtime_error with file, line and reason on others and on malformed lines.
ColmapModel readColmapModel(const std::string& directory);
void writeColmapModel(const std::string& directory, const ColmapModel& model);

}  // namespace cloud_colorizer
