// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause

/// The coloured points of a map, for programs that want some of them.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <functional>

#include "cloud_colorizer/map/params.hpp"
#include "cloud_colorizer/recording/recording.hpp"

namespace cloud_colorizer {

/// Calls f(position, 0x00RRGGBB) for every k-th point that has a colour, so that there are at most `most`. Positions
/// are relative to the recording's origin, or in the map frame. Throws as forEachColoredTile().
void forSomeColoredPoints(const Recording& recording, const Params& params, std::size_t most, bool relative,
                          const std::function<void(const Eigen::Vector3d&, std::uint32_t)>& f);

}  // namespace cloud_colorizer
