// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause

/// Scores of a coloured map of what `simulate city` wrote, whatever its size.
#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "cloud_colorizer/cloud/cloud.hpp"
#include "cloud_colorizer/map/chunks.hpp"
#include "cloud_colorizer/recording/recording.hpp"
#include "evaluation/clouds.hpp"

namespace cloud_colorizer {

/// Steps of the error from one side of a border between chunks to the other, and, for comparison, those between two
/// strips of the same width on one side of it.
class CitySeams {
 public:
  CitySeams(const Recording& recording, const ChunkParams& params);

  /// A coloured point (map frame, m) and its signed error, of 255.
  void add(const Eigen::Vector3d& point, double error);

  struct Steps {
    double at_borders = 0, beside = 0;  ///< of 255, mean absolute
  };
  Steps steps() const;

 private:
  /// Axis and tile of the plane, and the cell in the plane.
  using Place = std::array<std::int32_t, 4>;
  /// Two strips on each side of the plane, in their order along the axis.
  struct Strips {
    std::array<double, 4> sum{};
    std::array<std::uint32_t, 4> count{};
  };
  struct Box {
    TileIndex low{}, high{};
  };
  void addToPlane(std::size_t axis, std::int32_t plane, const Eigen::Vector3d& point, double error);

  Eigen::Vector3d origin_;
  double tile_size_, width_;  ///< m
  std::map<TileIndex, Box> box_of_tile_;
  std::map<Place, Strips> places_;
};

/// Of all points: the shares that are coloured; of a sample of them: the errors.
class CityScore {
 public:
  /// `truth_fields`: of the clouds with the truth. `num_points`: of the whole map. Throws std::runtime_error, naming
  /// `truth_source`, when a field is missing.
  CityScore(const std::vector<Field>& truth_fields, const std::string& truth_source, std::size_t num_points,
            std::string map_source);

  /// Further points of the map, and the same points with their truth; both may be one. `seams` may be null. Throws
  /// std::runtime_error where the points are not the same.
  void add(const Cloud& map, const Cloud& truth, CitySeams* seams);

  std::string describe() const;  ///< lines

 private:
  struct Share {
    std::uint64_t all = 0, colored = 0;
    std::string describe() const;
  };
  std::string source_;
  std::array<LocatedField, 3> true_color_;
  LocatedField seen_, hidden_;
  std::size_t step_, next_ = 0;  ///< every step_-th point is in the sample
  Share visible_, hidden_share_;
  std::vector<float> truth_, colors_;  ///< of the sample, three a point
};

}  // namespace cloud_colorizer
