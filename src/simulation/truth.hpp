// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause

/// What is true about a drive: the colours of the surfaces, the views, and who sees what.
#pragma once

#include <Eigen/Geometry>
#include <cstdint>
#include <string>
#include <unordered_set>
#include <vector>

#include "cloud_colorizer/base/types.hpp"
#include "cloud_colorizer/camera/camera.hpp"
#include "simulation/drive.hpp"
#include "simulation/sensors.hpp"

namespace cloud_colorizer::simulation {

/// An image as it was really taken.
struct TrueView {
  Camera camera;
  Eigen::Isometry3d map_from_camera = Eigen::Isometry3d::Identity();
  double time = 0;  ///< s since the start of the drive
};

/// View of an image of the drive.
TrueView trueView(const Drive& drive, int camera, int frame);

/// The same for a stamp of the bag [s since 1970]. Throws std::invalid_argument when no image of the camera has it
/// (to 1 ms).
TrueView trueViewOfStamp(const Drive& drive, int camera, double image_stamp);

enum class Truth : std::uint8_t {
  kOutOfView,  ///< in no view's image within the distance limit
  kHidden,     ///< in some view's image, and something stands between in every one of them
  kVisible,    ///< a free line of sight to some view
  kNoSurface,  ///< farther from every standing surface than the limit (a moving car's points)
};

/// What a view has of a surface point [m, map]: it is not in the image or farther than max_distance; something stands
/// between; or the line of sight is free.
enum class LineOfSight { kOutOfView, kBlocked, kFree };
LineOfSight lineOfSight(const Scene& scene, const Hit& surface, const TrueView& view, double max_distance);

struct PointTruth {
  Truth truth = Truth::kNoSurface;
  bool is_near_edge = false;      ///< within edge_distance another face is as near: what it saw is ambiguous
  float surface_distance = 0;     ///< m, from the point to the true surface
  Color color{0, 0, 0};           ///< true colour there
  std::uint16_t num_visible = 0;  ///< views with a free line of sight (all of them are counted)
};

struct TruthOptions {
  double max_view_distance = 40;  ///< m
  double surface_distance = 0.4;  ///< m; points farther from every surface have no truth
  double edge_distance = 0.03;    ///< m
  int num_threads = 0;
};

/// Truth of map points (3 x n, m, map frame; they may carry the noise of the map). Each is moved to the nearest true
/// surface; from there, a little in front of it, rays go to the views. O(n * views), exact.
std::vector<PointTruth> trueVisibility(const Scene& scene, const Eigen::Matrix3Xd& points,
                                       const std::vector<TrueView>& views, const TruthOptions& options);

/// Returns of the LiDAR without noise on what stands, one a voxel (the first one), with true colours.
class TruthCloud {
 public:
  /// `with_quantities`: also label (uchar) and temperature (float).
  explicit TruthCloud(double voxel_size, bool with_quantities = false)
      : voxel_size_(voxel_size), with_quantities_(with_quantities) {}
  void add(const Scene& scene, const std::vector<Return>& returns);
  std::size_t size() const { return colors_.size() / 3; }

  /// Binary PLY: x y z (double), red green blue (uchar). Throws std::runtime_error when it cannot be written.
  void write(const std::string& path) const;

 private:
  double voxel_size_;
  bool with_quantities_;
  std::unordered_set<std::uint64_t> taken_;
  std::vector<Eigen::Vector3d> positions_;
  std::vector<std::uint8_t> colors_, labels_;
};

/// truth_poses.csv: camera, frame, stamp, gains, map_from_camera of every image. Throws std::runtime_error.
void writeTruePoses(const Drive& drive, const std::string& path);

/// scene.yaml: the options, and true and given extrinsics. Throws std::runtime_error.
void writeSceneFile(const Drive& drive, const std::string& path);

}  // namespace cloud_colorizer::simulation
