// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause

/// A held-out image at the points of a map.
#pragma once

#include <memory>
#include <opencv2/core.hpp>
#include <optional>
#include <vector>

#include "cloud_colorizer/camera/view.hpp"
#include "cloud_colorizer/map/params.hpp"
#include "cloud_colorizer/visibility/depth_image.hpp"

namespace cloud_colorizer {

/// What an image shows at the points that its view sees.
struct SeenImage {
  std::vector<Eigen::Index> points;
  std::vector<float> depths, pixel_radii;
  std::vector<Eigen::Vector2f> pixels;
  Values values;  ///< 3 x number of points
};

/// A view that is held out.
struct HeldoutView {
  const View& view;
  const Camera& camera;
  cv::Mat3b image;
  cv::Mat mask;                                   ///< empty: none
  std::shared_ptr<const EmptySpace> empty_space;  ///< of the scan of its moment; may be null

  /// All points that it sees clearly from its own pose, whatever their colour.
  SeenImage at(PointsRef points, const Surfels& surfels, const Params& params) const;
  /// The points in the image that the scan of its moment hit, so that they were certainly in sight.
  std::vector<Eigen::Index> measured(PointsRef points) const;
  /// The points that were seen, where the image shows them from another pose.
  SeenImage from(const Eigen::Isometry3d& map_from_camera, PointsRef points, const SeenImage& seen) const;

 private:
  /// Of a point in the camera's frame; nothing beside the usable image, and where the mask forbids it.
  std::optional<Eigen::Vector2f> pixelOf(const Eigen::Vector3f& point) const;
};

}  // namespace cloud_colorizer
