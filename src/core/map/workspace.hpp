// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause

/// What the stages of one colouring share: what is read again and again, in bounded memory, and how each view is used.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "cloud_colorizer/camera/camera.hpp"
#include "cloud_colorizer/map/params.hpp"
#include "cloud_colorizer/recording/recording.hpp"
#include "cloud_colorizer/visibility/observe.hpp"
#include "map/decoded_images.hpp"
#include "map/derived_files.hpp"
#include "map/lru_cache.hpp"
#include "map/memory_plan.hpp"
#include "recording/scan_times.hpp"
#include "surface/surface.hpp"
#include "visibility/view_cones.hpp"

namespace cloud_colorizer {

class Workspace {
 public:
  /// `alone`: no other program works on the recording meanwhile, so that what it leaves for others may go.
  Workspace(const Recording& recording, const Params& params, bool alone = false);

  const Recording& recording() const { return recording_; }
  const Params& params() const { return params_; }
  const DerivedFiles& files() const { return files_; }
  const Camera& cameraOf(std::size_t view) const { return cameras_[view]; }
  const MemoryPlan& memory() const { return memory_; }

  std::shared_ptr<const Surface> surface(std::size_t tile) { return surfaces_.get(tile); }
  /// As far thinned as a view's depth image at that place [m] cannot tell.
  std::shared_ptr<const Surface> surfaceSeenFrom(std::size_t tile, std::size_t view, const Eigen::Vector3d& eye);
  std::shared_ptr<const ScanRanges> scan(std::size_t scan) { return scans_.get(scan); }
  std::shared_ptr<const cv::Mat> image(std::size_t view) { return imageOf(images_.get(view)); }
  std::shared_ptr<const cv::Mat> mask(std::size_t view) { return maskOf(images_.get(view)); }  ///< null: none
  /// What the scans of a view's moment tell; null where there are none. The view may be at another pose than its own.
  std::shared_ptr<const EmptySpace> emptySpace(std::size_t view, const Eigen::Isometry3d& map_from_camera);
  /// Everything that observe() needs of a view.
  ObservedView observedView(std::size_t view);

  /// The views whose image can be used, ascending; at first all.
  const std::vector<std::size_t>& usableViews() const { return usable_views_; }
  const ViewList& damagedViews() const { return damaged_views_; }
  void leaveOut(ViewList damaged);
  /// Those of them that show colours.
  std::vector<std::size_t> colorViews() const;
  /// All usable ones of a quantity (of the default: colours) that may show a point in the box.
  std::vector<std::size_t> viewsOf(const Eigen::AlignedBox3f& box, const Quantity& quantity = {}) const;

  /// Poses and exposures to use instead of the recording's, one a view.
  const std::vector<CorrectedView>& corrections() const { return corrections_; }
  void correctViews(std::vector<CorrectedView> corrections);

  /// Take from the files of an earlier run what it found out with the same recording and parameters; false where there
  /// is none, or it is damaged.
  bool restoreDamagedViews();
  bool restoreCorrections();

 private:
  static std::shared_ptr<const cv::Mat> imageOf(const std::shared_ptr<const ViewPixels>& pixels) {
    return {pixels, &pixels->image};
  }
  static std::shared_ptr<const cv::Mat> maskOf(const std::shared_ptr<const ViewPixels>& pixels) {
    if (pixels->mask.empty()) return nullptr;
    return {pixels, &pixels->mask};
  }

  Recording recording_;
  Params params_;
  MemoryPlan memory_;
  DerivedFiles files_;
  std::vector<Camera> cameras_;  ///< of every view
  ViewList damaged_views_;
  std::vector<std::size_t> usable_views_;
  std::vector<CorrectedView> corrections_;  ///< one a view
  std::vector<ViewCone> cones_;             ///< one a view
  ScanTimes scan_times_;
  LruCache<ScanRanges> scans_;
  LruCache<Surface> surfaces_;
  LruCache<std::vector<ThinnedLevel>> thinned_levels_;
  LruCache<Surface> thinned_;  ///< by tile and level
  DecodedImages images_;
  LruCache<DepthImage> depths_;
};

}  // namespace cloud_colorizer
