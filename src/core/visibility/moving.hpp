// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause

/// What moved: the trail of points that a vehicle leaves in a map. Scans of other moments saw through it.
#pragma once

#include <cstdint>
#include <vector>

#include "cloud_colorizer/base/types.hpp"
#include "cloud_colorizer/visibility/empty_space.hpp"

namespace cloud_colorizer {

/// From this share on, of 255, a point belongs to something that moved: more scans saw through it than ended there.
constexpr std::uint8_t kMovingShare = 128;

/// Counts, for each point, the scans that saw through it and those that ended there.
class MovingVotes {
 public:
  explicit MovingVotes(std::size_t num_points) : through_(num_points), hit_(num_points) {}

  /// `scan` in the frame of the points [m]. Any number of scans, the same number of points each time.
  void add(const PlacedScan& scan, PointsRef points);

  /// Of each point the share of scans that saw through it, 0 to 255; 0 where fewer than two did: one may err.
  std::vector<std::uint8_t> shares() const;

 private:
  std::vector<std::uint16_t> through_, hit_;
};

}  // namespace cloud_colorizer
