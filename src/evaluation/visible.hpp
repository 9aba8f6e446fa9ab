// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause

/// Of what was certainly seen, the share that got a colour.
#pragma once

#include <Eigen/Geometry>
#include <memory>
#include <string>

#include "cloud_colorizer/camera/camera.hpp"
#include "cloud_colorizer/cloud/cloud.hpp"

namespace cloud_colorizer {

struct VisibleCounts {
  std::size_t views = 0;
  std::size_t seen = 0;     ///< returns that fall into the image of their moment, or points that are told to be seen
  std::size_t in_map = 0;   ///< those of them with a point of the map nearby
  std::size_t colored = 0;  ///< those of them whose point has a colour

  void add(const VisibleCounts& other);
  std::string describe() const;
};

/// Points whose field `seen` is above 0 were seen. Throws std::runtime_error, naming `source`, when there is no such
/// field or there are no colours.
VisibleCounts countSeen(const Cloud& cloud, const std::string& source);

/// Of the returns of a scan that fall into an image of the same moment, how many have a colour in a map.
class VisibleReturns {
 public:
  /// `max_distance` [m] from a return to its point of the map; 0: three times the median distance between neighbours
  /// of the map. Throws std::runtime_error, naming `source`, when the cloud has no colours or fewer than two points.
  VisibleReturns(const Cloud& map, const std::string& source, double max_distance);
  ~VisibleReturns();

  double maxDistance() const;  ///< m
  /// `returns` [m] in the map's frame.
  VisibleCounts count(const Eigen::Matrix3Xd& returns, const Camera& camera,
                      const Eigen::Isometry3d& map_from_camera) const;

 private:
  struct Impl;
  std::unique_ptr<const Impl> impl_;
};

}  // namespace cloud_colorizer
