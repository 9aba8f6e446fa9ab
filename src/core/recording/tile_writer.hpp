// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause

/// Thins points to one a voxel and appends them to the tiles. Holds the voxels of the tiles used last.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <unordered_map>
#include <vector>

#include "recording/recording_files.hpp"
#include "recording/tile_grid.hpp"
#include "recording/voxel_set.hpp"

namespace cloud_colorizer {

struct PlacedPoint {
  std::array<float, 3> position{};  ///< m, relative to the origin
  std::uint32_t source = 0;         ///< index in its cloud
  TileCell cell;
};

class TileWriter {
 public:
  /// Called with a tile and its number of points before its file grows.
  using BeforeGrowth = std::function<void(const TileIndex&, std::uint64_t)>;

  TileWriter(const std::string& directory, const RecordingInfo& info, std::size_t max_open_tiles,
             const std::vector<Tile>& saved_tiles, BeforeGrowth before_growth);

  /// The first point of a voxel stays, whichever cloud it comes from. Returns how many were added.
  /// `records`: those of the whole cloud, `source_size` bytes each, turned into ours by `record_map`.
  std::size_t insert(const std::vector<PlacedPoint>& points, const std::uint8_t* records, std::size_t source_size,
                     const RecordMap& record_map);
  void flush();
  std::size_t numPoints() const { return num_points_; }  ///< also those that are not yet in a file
  std::size_t numPendingBytes() const { return num_pending_bytes_; }

 private:
  struct OpenTile {
    VoxelSet voxels;
    std::vector<std::uint8_t> pending;  ///< records that are not yet in the file
    std::uint64_t last_used = 0;
  };
  struct IndexHash {
    std::size_t operator()(const TileIndex& index) const;
  };

  OpenTile& open(const TileIndex& index);
  VoxelSet savedVoxels(const TileIndex& index) const;
  void closeLeastRecentlyUsed();
  void save(const TileIndex& index, OpenTile& tile);

  std::string directory_;
  std::vector<Field> fields_;
  std::size_t record_size_ = 0;
  bool has_voxels_ = false;
  TileGrid grid_;
  std::size_t max_open_tiles_ = 0;
  BeforeGrowth before_growth_;
  std::map<TileIndex, std::uint64_t> num_saved_;  ///< points in the file of every tile
  std::unordered_map<TileIndex, std::unique_ptr<OpenTile>, IndexHash> open_tiles_;
  std::uint64_t num_uses_ = 0;
  std::size_t num_points_ = 0;
  std::size_t num_pending_bytes_ = 0;
};

}  // namespace cloud_colorizer
