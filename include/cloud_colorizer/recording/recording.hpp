// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause

/// A recording: the directory between collecting and colouring. Append-only, readable with ordinary tools:
///   recording.yaml   format version, map frame and its coordinate reference system, origin, voxel and tile size,
///   fields
///                    of a point
///   cameras.yaml     intrinsics and mask of every camera
///   views.csv        one line a view: camera, stamp, pose, image file
///   readouts.csv     one line a view of a rolling shutter: its number, and how its camera moved while it was read
///   images/camera_i/ the images as received, and NUMBER.mask.png beside those that have a mask of their own
///   scans.csv        one line a scan: stamp, pose, file of ranges
///   scans/           which ranges the sensor measured at that moment, as 16 bit PNG
///   tiles/x_y_z.pcd  the points of one cube, positions relative to the origin
///   clouds.csv       one line a cloud whose points are all in the tiles; tiles.undo: which points to take out else
/// Whatever else lies in it (depth/, colored/, ...) is derived and may be deleted.
#pragma once

#include <Eigen/Geometry>
#include <array>
#include <cstdint>
#include <memory>
#include <opencv2/core.hpp>
#include <string>
#include <vector>

#include "cloud_colorizer/base/types.hpp"
#include "cloud_colorizer/camera/camera.hpp"
#include "cloud_colorizer/camera/view.hpp"
#include "cloud_colorizer/cloud/cloud.hpp"

namespace cloud_colorizer {

struct RecordedCamera {
  std::string name;  ///< "camera_0"; also the folder of its images
  Intrinsics intrinsics;
  std::string mask;   ///< file relative to the recording, CV_8UC1, 0 = do not use; empty: none
  Quantity quantity;  ///< its names are a file relative to the recording
};

/// What a view shows, and which of it can be used.
struct ViewPixels {
  cv::Mat image;  ///< CV_8UC3, RGB; grey images become grey RGB. Of what are no colours, see shownValues()
  cv::Mat mask;   ///< CV_8UC1, 0 = do not use; empty: all can be used
};

/// One sweep of a range sensor, kept as a panorama of ranges.
struct Scan {
  double stamp = 0;                                                   ///< s
  Eigen::Isometry3d map_from_sensor = Eigen::Isometry3d::Identity();  ///< relative to the recording's origin
  std::string image;                                                  ///< file, relative to the recording
};

using TileIndex = std::array<std::int32_t, 3>;

struct Tile {
  TileIndex index{};  ///< the cube [index, index + 1) * tile_size
  std::size_t num_points = 0;
};

/// Read-only state of a recording at one moment; cheap to copy; stays valid while a Recorder appends.
/// All functions are safe to call from several threads.
class Recording {
 public:
  /// Throws std::runtime_error: not a recording, another format version, damaged.
  static Recording open(const std::string& directory);

  const std::string& directory() const;
  const std::string& mapFrame() const;
  const std::string& crs() const;         ///< of the map frame: well-known text or "EPSG:25832"; empty: unknown
  const Eigen::Vector3d& origin() const;  ///< m, of all positions and poses, in the map frame
  double voxelSize() const;
  double tileSize() const;
  double maxRange() const;                   ///< m, of the points from their sensor; infinite where nobody limited it
  const std::vector<Field>& fields() const;  ///< of a point, without x, y, z
  const std::vector<RecordedCamera>& cameras() const;
  const std::vector<View>& views() const;
  const std::vector<Scan>& scans() const;
  const std::vector<Tile>& tiles() const;               ///< ascending by index
  Eigen::AlignedBox3f tileBox(std::size_t tile) const;  ///< m, the cube of a tile, relative to the origin
  std::size_t numPoints() const;

  Points readPoints(std::size_t tile) const;                      ///< positions relative to the origin
  std::vector<std::uint8_t> readRecords(std::size_t tile) const;  ///< packed records of fields()
  /// The mask is that of the camera, of the view, and of the image's alpha together. Throws when one is undecodable.
  ViewPixels readPixels(std::size_t view) const;
  const Quantity& quantityOf(std::size_t view) const;
  bool hasColors() const;  ///< whether any camera shows colours
  /// All but colours, each once, in the order of the cameras.
  std::vector<Quantity> quantities() const;
  cv::Mat readMask(std::size_t camera) const;  ///< CV_8UC1, or empty when the camera has none
  cv::Mat1w readScan(std::size_t scan) const;  ///< of makeRangePanorama()

 private:
  friend class Recorder;
  struct State;
  std::shared_ptr<const State> state_;
};

}  // namespace cloud_colorizer
