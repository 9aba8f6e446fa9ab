// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause

/// How well a coloured map predicts images that it was not coloured from.
#pragma once

#include <string>
#include <vector>

#include "cloud_colorizer/color/graph.hpp"
#include "evaluation/seen_image.hpp"

namespace cloud_colorizer {

/// The map coloured by one method.
struct ColoredMap {
  std::string method;
  std::vector<Eigen::Isometry3d> poses;  ///< of the views that it was coloured from, as the method used them
  Points points;
  Values colors;
  std::vector<std::uint8_t> colored;
};

/// Errors of one method in one or more images.
struct HeldoutErrors {
  std::vector<float> raw, after_gain, given, trimmed, refined;  ///< mean over the channels, by point
  /// px, of blocks of the image: shift from the pose that goes with the map, from the refined one, its standard error
  std::vector<float> shifts, warps, shift_errors;
  double squares = 0;  ///< sum over points and channels, after the gain
  std::size_t visible = 0, colored = 0, moved = 0;
  std::size_t measured = 0, measured_colored = 0;  ///< points that a scan of the moment hit, in the image
  double seam = 0;
  std::size_t seam_pairs = 0;

  void add(const HeldoutErrors& other);
  void countMeasured(const ColoredMap& map, const std::vector<Eigen::Index>& points);
  static std::vector<std::string> header();  ///< "method", and what cells() tells
  std::vector<std::string> cells(const std::string& method) const;
};

/// The map's colours at the points of an image, brought to the image's exposure by one gain a channel.
Values predict(const ColoredMap& map, const SeenImage& seen, bool with_gain);

/// Points where even the median of the views is farther than `threshold` from the image: moved, or reflecting.
std::vector<std::uint8_t> movedPoints(const ColoredMap& median, const SeenImage& seen, double threshold);

/// `neighbors`: pairs of points at which steps count that the image does not have (seams).
HeldoutErrors compareWithImage(const ColoredMap& map, const SeenImage& seen, const std::vector<std::uint8_t>& moved,
                               const std::vector<Edge>& neighbors);

/// Short links of the surface: those of one Z-order pass that are not longer than three times their median.
std::vector<Edge> shortLinks(PointsRef points);

}  // namespace cloud_colorizer
