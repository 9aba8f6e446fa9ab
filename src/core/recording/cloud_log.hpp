// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause

/// Which clouds are whole in the tiles, so that a program that was killed and reads its bag again neither doubles nor
/// loses a point:
///   clouds.csv   one line a cloud whose points are all in the files
///   tiles.undo   for each tile that grew since the last of these lines: how many points it had before
/// With voxels, a point that comes again finds its voxel taken; then there is nothing to undo.
#pragma once

#include <cstdint>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "base/file_io.hpp"
#include "cloud_colorizer/recording/recorder.hpp"
#include "recording/recording_tables.hpp"

namespace cloud_colorizer {

/// Of a recording that a killed program left: takes the points out of the tiles that belong to no whole cloud.
void undoTiles(const std::string& directory, const std::vector<Field>& fields);

class CloudLog {
 public:
  CloudLog(const std::string& directory, bool with_undo);

  /// True once for each cloud of this source that an earlier program recorded.
  bool recognize(const CloudSource& source);
  void add(const CloudSource& source);  ///< its points wait for the next flush of the tiles
  /// To be called before a tile's file grows.
  void noteGrowth(const TileIndex& tile, std::uint64_t num_points);
  void commit();  ///< all points are in the files

 private:
  TableWriter table_;
  std::multiset<std::string> earlier_;  ///< lines
  std::string waiting_;                 ///< lines of clouds whose points are not all in the files
  std::uint64_t num_bytes_;             ///< of clouds.csv
  std::optional<File> undo_;
  std::uint64_t undo_size_ = 0;
  std::set<TileIndex> noted_;
};

}  // namespace cloud_colorizer
