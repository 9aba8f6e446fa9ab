// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause

/// The tiles of a coloured map, as they are saved.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <vector>

#include "cloud_colorizer/map/colorize.hpp"
#include "map/workspace.hpp"
#include "recording/tile_range.hpp"

namespace cloud_colorizer {

/// What is saved of a tile, one column or element a point.
struct ShownTile {
  std::size_t tile = 0;
  Points points;
  TileColors colors;                 ///< as they are shown: 0 to 255
  Values radiance;                   ///< 3 x n, or empty: not saved
  std::vector<std::uint8_t> moving;  ///< or empty: not saved
  std::vector<bool> keep;            ///< false: left out
};

/// The colours that were made with these parameters; nobody colours anew while they are read.
class ColoredTiles {
 public:
  /// Throws where there are none.
  ColoredTiles(const Recording& recording, const Params& params);

  Workspace& work() { return work_; }
  const Recording& recording() const { return work_.recording(); }
  /// Of these tiles, the points that are saved.
  std::size_t countPoints(const TileIds& tiles) const;
  /// Tile by tile. Positions are relative to the origin where `relative`.
  void visit(const TileIds& tiles, bool relative, const std::function<void(const Cloud&)>& visitor);
  void visitShown(const TileIds& tiles, const std::function<void(const ShownTile&)>& visitor);

 private:
  std::vector<std::uint8_t> movingOf(std::size_t tile) const;
  std::vector<bool> kept(const TileColors& colors, const std::vector<std::uint8_t>& moving) const;

  FolderLock lock_;
  Workspace work_;
  std::optional<ToneField> tone_;
};

}  // namespace cloud_colorizer
