// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause

/// Whether the borders of chunks can be seen: colours on both sides of them, against both sides of other such planes.
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

  std::size_t numBorderCells() const { return border_.count; }
  /// grey levels by which neighbours differ more where a chunk ends; 0: no more, or too little was seen.
  double excess() const;

 private:
  struct Color {
    Eigen::Vector3f sum = Eigen::Vector3f::Zero();
    float count = 0;
  };
  using Cell = std::array<std::int32_t, 2>;
  using Side = std::map<Cell, Color>;
  struct Steps {
    double sum = 0;  ///< grey levels
    std::size_t count = 0;
  };

  Side sideOf(const ShownTile& shown, int axis, bool high) const;

  const Recording& recording_;
  std::vector<std::size_t> chunk_of_;                 ///< by tile
  float reach_;                                       ///< m, of cells, and from a plane
  std::map<std::array<std::int32_t, 4>, Side> open_;  ///< axis and tile beyond it, whose points are still to come
  Steps border_, inside_;
};

}  // namespace cloud_colorizer
