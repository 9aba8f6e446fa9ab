// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause

/// COLMAP's models: how other programs hand over cameras and poses.
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

/// A 3D point of a model, and where images saw it.
struct ColmapPoint {
  struct Sight {
    std::size_t image = 0;  ///< index into ColmapModel::images
    Eigen::Vector2d pixel;  ///< with pixel centres at integers
  };
  Eigen::Vector3d position{0, 0, 0};
  std::vector<Sight> sights;
};

/// Principal points are in our convention (pixel centres at integers): COLMAP's minus 0.5.
struct ColmapModel {
  std::vector<Intrinsics> cameras;
  std::vector<ColmapImage> images;  ///< by ascending image id
  std::vector<ColmapPoint> points;  ///< some thousand of them, to compare with; empty where the model has none
  std::string points_error;         ///< why the file of points cannot be read; empty: it can, or there is none
  std::string directory;            ///< where it was found
};

/// Reads a binary or text model from `directory`, from `sparse` in it, or from the only numbered folder (`sparse/0`).
/// The poses of frames.* (COLMAP 3.12) count where it is there. Every camera model of COLMAP 3 is known; FOV becomes a
/// rational polynomial that follows it to a tenth of a pixel, and THIN_PRISM_FISHEYE must be without its tangential and
/// prism coefficients. Throws std::runtime_error with file, line, reason and remedy.
ColmapModel readColmapModel(const std::string& directory);
void writeColmapModel(const std::string& directory, const ColmapModel& model);

}  // namespace cloud_colorizer
