// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause

/// Depth images: what each view can see of the whole map.
#pragma once

#include <Eigen/Geometry>
#include <opencv2/core.hpp>

#include "cloud_colorizer/camera.hpp"
#include "cloud_colorizer/surfels.hpp"
#include "cloud_colorizer/types.hpp"

namespace cloud_colorizer {

struct DepthParams {
  double depth_cell_size = 2;     ///< px of the image to a cell of the depth image
  double depth_tolerance = 0.01;  ///< share of the depth by which a visible point may lie behind the surface
  double depth_edge_guard = 3;    ///< px; nearer than this to a depth edge an observation counts as "edge"
  double max_view_distance = 40;  ///< m; views farther from a point than this do not colour it

  void check() const;
};

enum class Visibility { kHidden, kEdge, kVisible };

/// Depth of the nearest surface (along z of the camera's frame, m), on a grid of cells; +infinity where there is none.
struct DepthImage {
  cv::Mat1f depth;
  cv::Mat1b edge;       ///< non-zero within the guard band of a depth edge
  float cell_size = 1;  ///< px

  /// Of a point at pixel (u, v) with depth z [m] and surfel radius r [m].
  Visibility test(const Eigen::Vector2f& pixel, float z, float radius, const DepthParams& params) const;
};

/// Accumulates surfels from any number of tiles; the order does not matter to the result.
class DepthSplatter {
 public:
  DepthSplatter(const Camera& camera, const Eigen::Isometry3f& camera_from_map, const DepthParams& params);
  void add(PointsRef points, const Surfels& surfels);
  DepthImage finish() const;

 private:
  const Camera* camera_;
  Eigen::Isometry3f camera_from_map_;
  DepthParams params_;
  cv::Mat1f depth_;
};

}  // namespace cloud_colorizer
