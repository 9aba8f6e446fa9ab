// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause

/// What the files of a COLMAP model say, text or binary, before anything is made of it.
/// https://colmap.github.io/format.html
#pragma once

#include <Eigen/Geometry>
#include <cstdint>
#include <map>
#include <set>
#include <string>
#include <utility>
#include <vector>

namespace cloud_colorizer {

struct ColmapEntries {
  /// `where`: file, and line of a text file, for messages.
  struct Camera {
    long long id = 0, width = 0, height = 0;
    std::string model;
    std::vector<double> params;
    std::string where;
  };
  struct Pose {
    Eigen::Quaterniond rotation{1, 0, 0, 0};
    Eigen::Vector3d translation{0, 0, 0};
  };
  /// Where an image saw a 3D point.
  struct Sight {
    Eigen::Vector2d pixel;
    long long point = 0;
  };
  struct Image {
    long long id = 0, camera = 0;
    Pose camera_from_map;
    std::string name, where;
    std::vector<Sight> sights;  ///< kMostSights of them
  };
  /// A sensor: its type ("CAMERA", "IMU") and id.
  using Sensor = std::pair<std::string, long long>;
  struct Rig {
    long long id = 0;
    std::map<Sensor, Pose> sensor_from_rig;  ///< of those whose pose is known; the reference sensor's is the identity
  };
  struct Frame {
    long long rig = 0;
    Pose rig_from_map;
    std::vector<std::pair<Sensor, long long>> data;  ///< of a camera: an image id
    std::string where;
  };

  std::vector<Camera> cameras;
  std::vector<Image> images;
  std::vector<Rig> rigs;                        ///< since COLMAP 3.12; else empty
  std::vector<Frame> frames;                    ///< their poses count, not those of the images
  std::map<long long, Eigen::Vector3d> points;  ///< by id; those of the sights, and some others
  std::string points_error;                     ///< why they cannot be read; nothing but a check needs them

  static constexpr std::size_t kMostSights = 20;  ///< of an image
  static constexpr std::size_t kMostOtherPoints = 2000;
  std::set<long long> pointsOfSights() const;
  /// Keeps it where it is one of `wanted`, or of the first others.
  void addPoint(long long id, const Eigen::Vector3d& position, const std::set<long long>& wanted);
};

/// The first line of points3D.txt.
constexpr const char* kPointsHeader = "# POINT3D_ID, X, Y, Z, R, G, B, ERROR, TRACK[] as (IMAGE_ID, POINT2D_IDX)\n";

/// cameras.txt, images.txt, and where they are there points3D.txt, rigs.txt and frames.txt. Throws std::runtime_error
/// with file, line and reason.
ColmapEntries readColmapText(const std::string& directory);

/// The same of .bin files.
ColmapEntries readColmapBinary(const std::string& directory);

}  // namespace cloud_colorizer
