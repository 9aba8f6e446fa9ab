// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause

/// The derived files of a recording, and what is read again and again while colouring, in bounded memory.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "base/file_io.hpp"
#include "cloud_colorizer/camera/camera.hpp"
#include "cloud_colorizer/map/params.hpp"
#include "cloud_colorizer/recording/recording.hpp"
#include "cloud_colorizer/surface/surfels.hpp"
#include "cloud_colorizer/visibility/depth_image.hpp"
#include "cloud_colorizer/visibility/observe.hpp"
#include "map/fingerprint.hpp"
#include "map/lru_cache.hpp"
#include "recording/scan_times.hpp"
#include "surface/surface.hpp"

namespace cloud_colorizer {

/// Colours of one tile, one column a point.
struct TileColors {
  Values values;                     ///< 3 x n, 0 to 255; zero where count is 0
  std::vector<std::uint16_t> count;  ///< views that coloured the point
  std::vector<float> stddev;         ///< over the views
  std::vector<Unseen> unseen;        ///< why no view coloured the point
};

/// One program at a time colours a recording (exclusive); several may read its colours. Throws where another one is.
class FolderLock {
 public:
  FolderLock(const std::string& directory, bool exclusive);

 private:
  File file_;
};

/// Paths, files and caches of one colouring. A unit of work (a tile's surfels, a view's depth image, a tile's colours)
/// is one file, written under a temporary name and renamed: it is complete or absent. Each folder holds key.txt, which
/// tells what its files were made from; a folder with another key is emptied first.
class Workspace {
 public:
  Workspace(const Recording& recording, const Params& params);

  const Recording& recording() const { return recording_; }
  const Params& params() const { return params_; }
  const Camera& cameraOf(std::size_t view) const { return cameras_[recording_.views()[view].camera]; }

  bool hasSurfels(std::size_t tile) const;
  void writeSurfels(std::size_t tile, const Surfels& surfels) const;
  bool hasDepth(std::size_t view) const;
  void writeDepth(std::size_t view, const DepthImage& image) const;
  bool hasColors(std::size_t tile) const;
  void writeColors(std::size_t tile, const TileColors& colors) const;
  TileColors readColors(std::size_t tile) const;

  std::shared_ptr<const Surface> surface(std::size_t tile) { return surfaces_.get(tile); }
  /// Everything that observe() needs of a view.
  ObservedView observedView(std::size_t view);

  /// Whether any point of a box can lie in the view: nearer than max_view_distance and inside a cone around its image.
  bool mayObserve(std::size_t view, const Eigen::AlignedBox3f& box) const;
  std::vector<std::size_t> viewsOf(const Eigen::AlignedBox3f& box) const;  ///< all that may observe a point in it

  /// What the scans of a view's moment tell; null where there are none. The view may be at another pose than its own.
  std::shared_ptr<const EmptySpace> emptySpace(std::size_t view, const Eigen::Isometry3d& map_from_camera);

  std::shared_ptr<const cv::Mat> image(std::size_t view) { return images_.get(view); }
  std::shared_ptr<const cv::Mat> mask(std::size_t camera) const { return masks_[camera]; }

  /// Poses and exposures to use instead of the recording's, one a view; kept in a file.
  void correctViews(std::vector<CorrectedView> corrections);
  /// Takes them from the file of an earlier run with the same recording and parameters; false where there is none, or
  /// the method does not align.
  bool restoreCorrections();
  const CorrectedView& corrected(std::size_t view) const { return corrections_[view]; }

  /// Empty the folders whose files were made from something else: surfels and alignment; and, once the poses are what
  /// they will be, depth and colored.
  void prepareAlignment() const;
  void prepareColors() const;
  /// Throws unless the colours are there that these parameters give.
  void requireColors() const;

 private:
  std::string depthKeyOfAll() const;
  std::string colorsKeyOfAll() const;
  std::string tilePath(const char* folder, std::size_t tile) const;
  std::string depthPath(std::size_t view) const;
  Surface readSurface(std::size_t tile) const;
  DepthImage readDepth(std::size_t view);

  Recording recording_;
  Params params_;
  std::vector<Camera> cameras_;
  std::vector<double> cone_angles_;         ///< rad, one a camera: between its axis and the farthest image corner
  std::vector<CorrectedView> corrections_;  ///< one a view
  std::vector<std::shared_ptr<const cv::Mat>> masks_;
  ScanTimes scan_times_;
  LruCache<cv::Mat1w> scans_;  ///< of emptyRanges()
  LruCache<Surface> surfaces_;
  LruCache<cv::Mat> images_;
  LruCache<DepthImage> depths_;
};

}  // namespace cloud_colorizer
