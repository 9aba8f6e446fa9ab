// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause

/// Observations: the values of each point in each view that sees it.
#pragma once

#include <Eigen/Geometry>
#include <functional>
#include <memory>
#include <opencv2/core.hpp>
#include <vector>

#include "cloud_colorizer/base/types.hpp"
#include "cloud_colorizer/camera/camera.hpp"
#include "cloud_colorizer/camera/view.hpp"
#include "cloud_colorizer/visibility/depth_image.hpp"

namespace cloud_colorizer {

/// px at the border of an image that are not used: demosaicing and JPEG have seen half of their neighbours only.
constexpr double kImageBorder = 3;

struct ObserveParams {
  int max_views = 20;  ///< a point keeps its best views up to this number

  void check() const;
};

/// All that is needed of one view. Pointers are shared with caches; image and depth may be dropped after use.
struct ObservedView {
  std::uint32_t id = 0;  ///< written into Observations::views
  const Camera* camera = nullptr;
  Eigen::Isometry3d map_from_camera = Eigen::Isometry3d::Identity();
  std::shared_ptr<const cv::Mat> image;
  std::shared_ptr<const cv::Mat> mask;  ///< CV_8UC1, size of the image, 0 = do not use; may be null
  std::shared_ptr<const DepthImage> depth;
  Exposure exposure;
  float weight = 1;                    ///< 0 to 1, of all its observations
  ImageKind kind = ImageKind::kColor;  ///< of labels the nearest pixel counts; only colours are ever too bright
};

/// Compressed rows: the observations of point p are [offsets[p], offsets[p + 1]), by ascending view id.
struct Observations {
  std::vector<std::uint32_t> offsets;  ///< n + 1
  std::vector<std::uint32_t> views;    ///< view ids
  std::vector<float> distances;        ///< m, from the camera centre to the point
  std::vector<float> weights;          ///< 0 to 1, quality of the observation; small where saturated
  Values values;                       ///< m x number of observations, exposure applied

  std::size_t numPoints() const { return offsets.empty() ? 0 : offsets.size() - 1; }
  std::size_t numObservations() const { return views.size(); }
};

/// Why no view coloured a point. The values are in the order of the tests that a view makes, the last test first; of
/// all views the one that came through most tests counts.
enum class Unseen : std::uint8_t { kSeen, kMasked, kAbsent, kHidden, kTooFar, kOutside };

/// Why views did not see points: counts of (point, view) pairs.
struct ObserveStats {
  std::uint64_t outside = 0, too_far = 0, hidden = 0, absent = 0, masked = 0, edge = 0, seen = 0;
  std::uint64_t worse = 0;  ///< not looked at further: the point has max_views better views
};

struct ObserveResult {
  Observations observations;
  ObserveStats stats;
  std::vector<Unseen> unseen;  ///< one a point; kOutside when there is no view at all
};

/// Looks at every point from every view. `view(k)`, k in [0, num_views), is called once for each, in order.
/// A point that some view sees clearly keeps no edge observation; a point seen only at edges keeps those, unless it
/// is one such view and another takes the point for hidden.
ObserveResult observe(PointsRef points, const Surfels& surfels, std::size_t num_views,
                      const std::function<ObservedView(std::size_t)>& view, const DepthParams& depth_params,
                      const ObserveParams& params);

}  // namespace cloud_colorizer
