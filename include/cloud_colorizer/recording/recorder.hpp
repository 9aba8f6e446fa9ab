// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause

/// Filling a recording: thinned points, views and scans, appended as they come.
#pragma once

#include <Eigen/Geometry>
#include <cstdint>
#include <memory>
#include <opencv2/core.hpp>
#include <optional>
#include <string>
#include <vector>

#include "cloud_colorizer/camera/camera.hpp"
#include "cloud_colorizer/cloud/cloud.hpp"
#include "cloud_colorizer/recording/recording.hpp"

namespace cloud_colorizer {

struct RecordParams {
  double voxel_size = 0.05;        ///< m; one point a voxel is kept; 0 keeps all
  double min_range = 1;            ///< m from the sensor; nearer points are dropped
  double max_range = 60;           ///< m from the sensor; farther points are dropped
  double tile_size = 0;            ///< m, side of a tile; 0: 200 voxels, or 2.5 m where voxel_size is 0
  double keyframe_distance = 0.5;  ///< m; a view is kept when its camera moved this far since its last view,
  double keyframe_angle = 10;      ///< deg; or turned by this angle
  double scan_resolution = 0.5;    ///< deg a cell of the scans that tell empty space; 0: none are kept, and none used
  int max_open_tiles = 1024;       ///< tiles whose voxels are held in memory; a 60 m scan touches about 400

  void check() const;
};

/// What tells a cloud apart from all others of a recording.
struct CloudSource {
  std::string sensor;  ///< any name that tells sensors apart, such as the frame
  double stamp = 0;    ///< s
};

/// Appends to a recording. Used from one thread at a time.
/// After flush() (and by itself about once a second) everything survives a SIGKILL of the process.
class Recorder {
 public:
  /// Creates the directory, or continues the recording in it. Throws std::runtime_error when it cannot, when the
  /// recording has another format version or another map frame, or was made with another voxel or tile size.
  Recorder(const std::string& directory, const std::string& map_frame, const RecordParams& params);
  ~Recorder();

  /// Of the map frame: well-known text or "EPSG:25832". It is only kept, for who reads the recording.
  void setCrs(const std::string& crs);

  /// Adds or finds the camera. One name may get new intrinsics later: views then refer to a new entry. A file of names
  /// is copied.
  std::uint32_t setCamera(const std::string& name, const Intrinsics& intrinsics, const Quantity& quantity = {});
  void setMask(std::uint32_t camera, const cv::Mat1b& mask);

  struct InsertCounts {
    std::size_t added = 0, not_finite = 0, too_near = 0, too_far = 0, voxel_taken = 0;
    std::vector<std::string> fields_dropped;  ///< of this cloud, since the recording does not have them
    std::vector<std::string> fields_missing;  ///< of the recording, zero for this cloud's points
  };
  /// Positions in the sensor's frame; fields that the recording does not know are dropped (the first cloud defines
  /// them), missing ones are zero.
  InsertCounts addCloud(const Cloud& cloud, const Eigen::Isometry3d& map_from_sensor,
                        const std::optional<CloudSource>& source = {});

  /// For a bag that is read again after its reader was killed: true where an earlier program recorded this cloud, or
  /// this view. Each is recognized once, so that a second round of a looped bag is new. Scans are recognized by
  /// addScan.
  bool recognizeCloud(const CloudSource& source);
  bool recognizeView(std::uint32_t camera, double stamp);

  /// The encoded image is written as it is, then the view. `extension` is "jpg", "png", "ppm", "pgm", ...
  /// map_from_camera is in the map frame, not yet relative to the origin. `mask` is the view's own beside its camera's,
  /// 0 = do not use; empty: none. With a `readout_motion`, map_from_camera is the pose of the middle row; see
  /// View::readout_motion. Returns the view's index.
  std::size_t addView(std::uint32_t camera, double stamp, const Eigen::Isometry3d& map_from_camera,
                      const std::vector<std::uint8_t>& encoded_image, const std::string& extension,
                      const cv::Mat1b& mask = {}, const Twist& readout_motion = Twist::Zero());

  /// Keeps which ranges a sensor measured at a moment, if it moved by a quarter of what makes a keyframe since its last
  /// scan. Positions in the sensor's frame; `sensor` is any name that tells sensors apart.
  void addScan(const std::string& sensor, double stamp, const Eigen::Matrix3Xd& positions,
               const Eigen::Isometry3d& map_from_sensor);

  void flush();
  bool isInPlace() const;  ///< false when the directory was deleted, moved away or replaced by another
  Recording snapshot();    ///< flushes
  std::size_t numPoints() const;
  std::size_t numViews() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace cloud_colorizer
