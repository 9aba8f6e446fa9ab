// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause

/// Whether the borders of chunks can be seen: colours on both sides of them, against those right beside.
#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <vector>

#include "cloud_colorizer/map/params.hpp"
#include "map/colored_tiles.hpp"

namespace cloud_colorizer {

class SeamMeter {
 public:
  SeamMeter(const Recording& recording, const Params& params);

  /// Tiles in their order.
  void add(const ShownTile& shown);

  std::size_t numBorderCells() const { return count_; }
  /// grey levels by which neighbours certainly differ more across a border of chunks than right beside it; 0: no more
  /// than by chance, or too little was seen. Beside it, and not anywhere: chunks are cut where the surface ends or has
  /// few points, and there colours differ by themselves.
  double excess() const;

 private:
  struct Color {
    Eigen::Vector3f sum = Eigen::Vector3f::Zero();
    float count = 0;

    void add(const Eigen::Vector3f& value) {
      sum += value;
      ++count;
    }
  };
  /// Of the points in a cell of the border: those next to it, and as many cells farther away.
  struct Column {
    Color near, far;
  };
  using Cell = std::array<std::int32_t, 2>;
  using Side = std::map<Cell, Column>;

  Side sideOf(const ShownTile& shown, int axis, bool high) const;
  void compare(const Side& low, const Side& high);

  const Recording& recording_;
  std::vector<std::size_t> chunk_of_;                 ///< by tile
  float reach_;                                       ///< m, of cells, and from a plane
  std::map<std::array<std::int32_t, 4>, Side> open_;  ///< axis and tile beyond it, whose points are still to come
  double sum_ = 0, squares_ = 0;                      ///< grey levels, over the cells of borders
  std::size_t count_ = 0;
};

}  // namespace cloud_colorizer
