// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause

/// A drive as a rosbag. Private to the program `simulate`.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "simulation/drive.hpp"
#include "simulation/quantities.hpp"
#include "simulation/sensors.hpp"

namespace cloud_colorizer::simulation {

using ImageBytes = std::vector<std::uint8_t>;  ///< as the camera's driver sends them: JPEG, or rgb8 rows

/// Writes messages at the times at which a live system would have received them; so the bag is the same every time.
/// The file has another name until close(): it is whole or absent.
class DriveBag {
 public:
  /// Topics: /lidar/points, /camera_i/image or /camera_i/image/compressed, /camera_i/camera_info, /tf, /tf_static.
  DriveBag(const std::string& path, const Drive& drive);
  ~DriveBag();

  /// The poses of tf up to `time` [s] that have not been written yet.
  void writePosesUntil(double time);
  void writeImage(int camera, int frame, const ImageBytes& image);
  /// At the image's time and place: CompressedImage /camera_i/labels/compressed (mono8), Image /camera_i/thermal
  /// (16UC1).
  void writeQuantities(int camera, int frame, const QuantityImages& images);
  void writeScan(int frame, const std::vector<Return>& returns);
  void close();

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

std::string imageTopic(const Drive& drive, int camera);
constexpr const char* kCloudTopic = "/lidar/points";

}  // namespace cloud_colorizer::simulation
