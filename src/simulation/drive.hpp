// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause

/// The vehicle's drive: where it truly is, where tf says it is, its sensors, their clocks and gains.
///
/// Frames: map, base_link (on the ground below the vehicle, x ahead, z up), lidar, camera_i_optical.
/// Times are seconds since the start of the drive, by the LiDAR's clock, unless they are called stamps.
#pragma once

#include <Eigen/Geometry>
#include <cstdint>
#include <string>
#include <vector>

#include "cloud_colorizer/camera/camera.hpp"
#include "simulation/material.hpp"
#include "simulation/options.hpp"
#include "simulation/street.hpp"

namespace cloud_colorizer::simulation {

struct DriveCamera {
  std::string name;   ///< "camera_0"
  std::string frame;  ///< "camera_0_optical"
  Camera camera;
  Eigen::Isometry3d base_from_camera;        ///< true
  Eigen::Isometry3d base_from_camera_given;  ///< what tf_static says
  double delay = 0;                          ///< s after the scan's stamp
  Color white_balance{1, 1, 1};
};

class Drive {
 public:
  /// Throws std::invalid_argument on bad options.
  explicit Drive(const Options& options);

  const Options& options() const { return options_; }
  const std::vector<DriveCamera>& cameras() const { return cameras_; }
  const Eigen::Isometry3d& baseFromLidar() const { return base_from_lidar_; }

  double duration() const;                               ///< s; poses are defined in [0, duration]
  double scanTime(int frame) const;                      ///< s, of the scan's stamp: the start of its sweep
  double imageTime(int camera, int frame) const;         ///< s, when the first row of the image was taken
  std::int64_t stamp(double time) const;                 ///< ns since 1970, of LiDAR and tf
  std::int64_t imageStamp(int camera, int frame) const;  ///< ns, with the cameras' time offset

  Eigen::Isometry3d mapFromBase(double time) const;       ///< true
  Eigen::Isometry3d mapFromBaseGiven(double time) const;  ///< what tf says
  /// True, when a share of the image was read: 0 at its first row, 1 after its last.
  Eigen::Isometry3d mapFromCamera(int camera, int frame, double share = 0.5) const;

  /// What the camera multiplies the true colour with: auto-exposure times white balance.
  Color gain(int camera, int frame) const;

 private:
  Options options_;
  Motion way_;
  std::vector<DriveCamera> cameras_;
  Eigen::Isometry3d base_from_lidar_;
};

/// The street that the vehicle of these options drives through.
StreetOptions streetOf(const Options& options);

}  // namespace cloud_colorizer::simulation
