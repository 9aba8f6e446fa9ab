// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause

/// What a view says of a point, against what the others say: an error that no colour was fitted to.
#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include "cloud_colorizer/base/types.hpp"
#include "cloud_colorizer/visibility/observe.hpp"

namespace cloud_colorizer {

/// The image of a camera in cells, row by row.
constexpr int kHeldOutColumns = 16, kHeldOutRows = 12;

/// One view of a point, left out and predicted from the others.
struct HeldOut {
  std::uint8_t camera = 0;  ///< up to 255
  std::uint8_t cell = 0;    ///< of the image that the point lies in
  std::uint8_t error = 0;   ///< grey levels, mean over the channels of the distance to the prediction
};

/// Where in an image a view sees a point: the camera, and the pixel as shares of width and height.
struct SightPlace {
  std::uint32_t camera = 0;
  Eigen::Vector2f place{0, 0};
};

/// For a fixed share of the points in `columns`, those that three views see at the least, one of the views, picked by
/// chance, against the weighted mean of the others.
std::vector<HeldOut> leaveOneOut(PointsRef points, const std::vector<Eigen::Index>& columns,
                                 const Observations& observations,
                                 const std::function<SightPlace(std::uint32_t view, const Eigen::Vector3f&)>& placeOf);

/// Of each point, the observation from nearest by; one past the last where no view sees it.
std::vector<std::uint32_t> nearestObservations(const Observations& observations);

}  // namespace cloud_colorizer
