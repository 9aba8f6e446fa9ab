// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause

/// The points of one tile: a binary PCD file that grows at its end. Records are written before the header's count, so
/// at any moment, also after a SIGKILL, the file begins with the header's number of whole points.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "cloud_colorizer/cloud/cloud.hpp"
#include "cloud_colorizer/recording/recording.hpp"

namespace cloud_colorizer {

constexpr std::size_t kPositionSize = 3 * sizeof(float);  ///< bytes at the start of a tile's record

std::string tileName(const TileIndex& index);  ///< x_y_z
std::string tilePath(const std::string& directory, const TileIndex& index);

/// The tiles of a recording whose points have `fields`, ascending by index, with the points that may be read.
/// Throws std::runtime_error on a file with other fields.
std::vector<Tile> listTiles(const std::string& directory, const std::vector<Field>& fields);

/// Bytes [begin, begin + size) of every one of the first `num_points` records, packed.
std::vector<std::uint8_t> readTileColumns(const std::string& directory, const Tile& tile,
                                          const std::vector<Field>& fields, std::size_t begin, std::size_t size);

/// Whole records in the file of a tile, whatever its header says: none where there is no file.
std::uint64_t countTileRecords(const std::string& directory, const TileIndex& index, const std::vector<Field>& fields);

/// Appends whole records behind the first `num_points`, or behind what is left of them where something has cut the
/// file; whatever a crash left there is overwritten. Returns how many points the file then has. When the disk is full
/// it throws and the file still holds `num_points`.
std::uint64_t appendToTile(const std::string& directory, const TileIndex& index, const std::vector<Field>& fields,
                           std::uint64_t num_points, const std::vector<std::uint8_t>& records);

/// Leaves the first `num_points` in the file; without any, no file.
void cutTile(const std::string& directory, const TileIndex& index, const std::vector<Field>& fields,
             std::uint64_t num_points);

}  // namespace cloud_colorizer
