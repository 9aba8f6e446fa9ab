// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause

/// Scores of colours against a truth.
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "cloud_colorizer/base/types.hpp"

namespace cloud_colorizer {

/// All errors in the units of a colour (0 to 255), over the coloured points only.
struct Score {
  std::size_t num_points = 0;  ///< coloured points that were compared
  double coverage = 0;         ///< share of the truth's points that are coloured
  double aep = 0;              ///< mean absolute error over points and channels
  double rep = 0;              ///< share of points with a mean error over the channels above 20
  double psnr = 0;             ///< dB; capped at 99
  double ciede2000 = 0;        ///< mean colour difference, sRGB under D65
  double aep_gain = 0;         ///< AEP and REP after one best common gain per channel, as the absolute brightness
  double rep_gain = 0;         ///<   of a scene cannot be observed
  Eigen::Array3d gain{1, 1, 1};
  std::string describe() const;  ///< one line
};

/// Columns are the same points; where `colored` is zero a point has no colour. Values are clamped to 0..255 first.
/// Throws std::invalid_argument when the sizes differ or nothing is coloured.
Score scoreColors(ValuesRef truth, ValuesRef result, const std::vector<std::uint8_t>& colored);

/// Compares two clouds: every point of the truth with the nearest coloured point of the result within `max_distance`
/// [m]. Throws std::runtime_error when no pair is that near.
Score scoreClouds(const Points& truth_points, ValuesRef truth, const Points& points, ValuesRef result,
                  double max_distance);

/// The gain g that minimises sum |truth - g * value| (weighted median of the ratios); 1 if all values are zero.
double bestGain(const std::vector<float>& truth, const std::vector<float>& values);

Eigen::Vector3d labFromRgb(const Eigen::Vector3d& rgb);                      ///< sRGB of 255 to CIE L*a*b*, white D65
double ciede2000(const Eigen::Vector3d& lab1, const Eigen::Vector3d& lab2);  ///< Sharma, Wu, Dalal 2005

}  // namespace cloud_colorizer
