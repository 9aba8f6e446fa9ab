// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause

/// Every k-th point of a coloured map, in memory: what is drawn and walked through.
#pragma once

#include <Eigen/Geometry>
#include <cstdint>
#include <limits>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "cloud_colorizer/map/colorize.hpp"

namespace cloud_colorizer {

struct MapSample {
  std::vector<float> positions;          ///< x y z a point [m], relative to the recording's origin
  std::vector<std::uint8_t> colors;      ///< red green blue a point
  std::vector<std::uint8_t> counts;      ///< of views, up to 255
  std::vector<std::uint8_t> deviations;  ///< of the colour, grey levels
  std::vector<std::uint8_t> moving;      ///< share of 255; 0 where the map does not tell
  std::vector<std::uint8_t> intensity;   ///< from the 1st to the 99th percentile; empty: the map has none
  std::vector<std::uint8_t> nearest;     ///< red green blue a point: what its nearest view shows
  std::vector<std::uint8_t> cameras;     ///< of that view
  std::vector<std::uint8_t> reasons;     ///< Unseen
  std::vector<float> thicknesses;        ///< m
  std::optional<double> seam;            ///< SeamMeter::excess() of the whole map; none where no border was seen

  std::size_t size() const { return counts.size(); }
  Eigen::AlignedBox3f coloredBox() const;  ///< of what has a colour, without the farthest hundredth on each side
};

MapSample sampleMap(const Recording& recording, const Params& params, std::size_t num_points, std::size_t most,
                    const Callbacks& callbacks);

/// {"count", "low", "step", "has_intensity"} and the bytes of the points in it, one array after the other, as base64:
/// uint16 x, y, z in steps from low; red, green, blue; the same of the nearest view; view count, deviation, moving,
/// reason, camera, thickness up to thickness_scale, and intensity if there is any.
/// Every k-th point, so that there are at most `most`.
nlohmann::json packSample(const MapSample& sample, std::string& base64,
                          std::size_t most = std::numeric_limits<std::size_t>::max());

float percentile(std::vector<float> values, double share);  ///< 0 of none

std::string base64Of(const std::uint8_t* bytes, std::size_t size);

}  // namespace cloud_colorizer
