// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause

/// What views that were left out say about cameras, exposures, and parts of the images.
#pragma once

#include <array>
#include <cstdint>
#include <nlohmann/json.hpp>
#include <vector>

#include "cloud_colorizer/recording/recording.hpp"
#include "color/held_out.hpp"

namespace cloud_colorizer {

/// Of one camera.
struct CameraErrors {
  static constexpr std::size_t kCells = std::size_t{kHeldOutColumns} * kHeldOutRows;

  std::array<std::uint64_t, 256> by_error{};  ///< sights, by grey levels
  std::array<std::uint64_t, kCells> sums{};   ///< grey levels, by cells of the image
  std::array<std::uint64_t, kCells> counts{};

  void add(const HeldOut& sight);
  std::uint64_t count() const;
  double mean() const;    ///< grey levels; 0 where there are none
  double median() const;  ///< grey levels
};

/// A part of a camera's images that shows what the map does not: the vehicle, dirt, or a mask that is missing.
struct BadPart {
  std::size_t camera = 0;
  double error_ratio = 0;                           ///< its error over the median of the camera's cells
  double share = 0;                                 ///< of the sights of the camera
  double left = 0, top = 0, right = 0, bottom = 0;  ///< shares of width and height
};

/// Of each camera, from the files of the coloured tiles.
std::vector<CameraErrors> readErrors(const Recording& recording);

/// The worst part that stands out, of all cameras; a ratio of 0: none.
BadPart worstPart(const std::vector<CameraErrors>& cameras);

/// {"error", "median", "points", "bin_width", "cameras": [{"error", "median", "points", "histogram"}], "worst_part":
/// {...}}.
nlohmann::json describeErrors(const std::vector<CameraErrors>& cameras);

}  // namespace cloud_colorizer
