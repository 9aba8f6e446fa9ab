// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause

/// Depth images: what each view can see of the whole map.
#pragma once

#include <Eigen/Geometry>
#include <limits>
#include <memory>
#include <opencv2/core.hpp>

#include "cloud_colorizer/base/types.hpp"
#include "cloud_colorizer/camera/camera.hpp"
#include "cloud_colorizer/surface/surfels.hpp"
#include "cloud_colorizer/visibility/empty_space.hpp"

namespace cloud_colorizer {

struct DepthParams {
  double depth_cell_size = 0;      ///< px of the image to a cell of the depth image; 0: as cellSize() tells
  double depth_tolerance = 0.002;  ///< share of the depth by which a visible point may lie behind the surface, besides
                                   ///< a quarter of its surfel radius and what the slant of the surface explains
  double depth_edge_guard = 3;     ///< px; nearer than this to a depth edge an observation counts as "edge"
  double max_view_distance = 0;    ///< m; views farther from a point than this do not colour it; 0: see reach()
  double clear_radius = 0;         ///< m; nothing that stays was so near to where a camera has been: it does not hide

  void check() const;
  /// m; max_view_distance, or two thirds of the range up to which a scanner's points were recorded (from farther away,
  /// too little of what hides a point is known), or no limit.
  double reach(double max_range = std::numeric_limits<double>::infinity()) const;
  /// px, for an image of this size: 1 / 640 of its longer side, but 2 px at least. Errors of poses and calibration are
  /// angles; they span the more pixels the more there are.
  double cellSize(const Intrinsics& intrinsics) const;
};

/// kAbsent: the scan of that moment saw through the place, so that nothing was there.
enum class Visibility { kHidden, kAbsent, kEdge, kVisible };

/// What a view has of a point.
struct Sight {
  Visibility visibility = Visibility::kHidden;
  float support = -1;  ///< from 1, on the surface that is seen or before it, by 0, as far behind as is allowed, to -1
};

/// Distance from the camera's centre to the nearest surface [m], on a grid of cells; +infinity where there is none.
/// (The distance and not z: then a fisheye may see behind its image plane.) Where a surface is slanted, a cell holds
/// the nearest that is in it. Holes of one cell between surfels are closed.
struct DepthImage {
  cv::Mat1f depth;
  cv::Mat1b edge;                                 ///< non-zero within the guard band of a depth edge
  float cell_size = 1;                            ///< px
  float pixel_angle = 1e-3F;                      ///< rad that a pixel spans, about
  std::shared_ptr<const EmptySpace> empty_space;  ///< points in it do not hide others, nor are they seen; may be null
  std::shared_ptr<const void> owner;              ///< of the cells, where depth and edge do not own them

  /// Of a point at pixel (u, v); point [m] and surfel normal (or zero) in the camera's frame, surfel radius and
  /// thickness [m].
  Sight look(const Eigen::Vector2f& pixel, const Eigen::Vector3f& point, const Eigen::Vector3f& normal, float radius,
             const DepthParams& params, float thickness = 0) const;
  Visibility test(const Eigen::Vector2f& pixel, const Eigen::Vector3f& point, const Eigen::Vector3f& normal,
                  float radius, const DepthParams& params, float thickness = 0) const {
    return look(pixel, point, normal, radius, params, thickness).visibility;
  }

 private:
  float slope(int row, int col) const;
};

/// Accumulates surfels from any number of tiles; the order does not matter to the result.
class DepthSplatter {
 public:
  DepthSplatter(const Camera& camera, const Eigen::Isometry3f& camera_from_map, const DepthParams& params,
                std::shared_ptr<const EmptySpace> empty_space = nullptr);
  void add(PointsRef points, const Surfels& surfels);
  DepthImage finish() const;

 private:
  void splat(const Eigen::Vector3f& point, const Eigen::Vector3f& normal, float radius);

  const Camera* camera_;
  Eigen::Isometry3f camera_from_map_;
  DepthParams params_;
  std::shared_ptr<const EmptySpace> empty_space_;
  cv::Mat1f inverse_;  ///< 1 / distance: planes are nearly linear in it, and 0 is nothing
};

}  // namespace cloud_colorizer
