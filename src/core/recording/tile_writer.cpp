// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause
#include "recording/tile_writer.hpp"

#include <algorithm>
#include <cstring>
#include <utility>

#include "recording/tile_file.hpp"

namespace cloud_colorizer {

namespace {

/// Points of one cloud that lie in one tile, in the order of the cloud.
struct TileGroup {
  TileIndex index{};
  std::vector<std::uint32_t> points;
};

template <class Hash>
std::vector<TileGroup> groupByTile(const std::vector<PlacedPoint>& points, const Hash&) {
  std::vector<TileGroup> groups;
  std::unordered_map<TileIndex, std::size_t, Hash> group_of;
  std::size_t current = 0;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const auto& tile = points[i].cell.tile;
    if (groups.empty() || groups[current].index != tile) {
      const auto [entry, is_new] = group_of.try_emplace(tile, groups.size());
      if (is_new) groups.push_back({tile, {}});
      current = entry->second;
    }
    groups[current].points.push_back(static_cast<std::uint32_t>(i));
  }
  return groups;
}

}  // namespace

std::size_t TileWriter::IndexHash::operator()(const TileIndex& index) const {
  std::uint64_t hash = 0;
  for (const auto value : index) hash = (hash ^ static_cast<std::uint32_t>(value)) * 0x9E3779B97F4A7C15U;
  return hash ^ hash >> 32U;
}

TileWriter::TileWriter(const std::string& directory, const RecordingInfo& info, std::size_t max_open_tiles,
                       const std::vector<Tile>& saved_tiles, BeforeGrowth before_growth)
    : directory_(directory),
      fields_(info.fields.value()),
      record_size_(kPositionSize + recordSize(fields_)),
      has_voxels_(info.voxel_size > 0),
      grid_(info.voxel_size, info.tile_size),
      max_open_tiles_(max_open_tiles),
      before_growth_(std::move(before_growth)) {
  for (const auto& tile : saved_tiles) {
    num_saved_[tile.index] = tile.num_points;
    num_points_ += tile.num_points;
  }
}

std::size_t TileWriter::insert(const std::vector<PlacedPoint>& points, const std::uint8_t* records,
                               std::size_t source_size, const RecordMap& record_map) {
  auto groups = groupByTile(points, IndexHash{});
  // Tiles that are open come first, so that none is closed just before it is needed.
  std::stable_partition(groups.begin(), groups.end(),
                        [&](const TileGroup& group) { return open_tiles_.count(group.index) > 0; });
  std::size_t num_added = 0;
  for (const auto& group : groups) {
    auto& tile = open(group.index);
    const auto size_before = tile.pending.size();
    for (const auto i : group.points) {
      const auto& point = points[i];
      const auto& voxel = point.cell.voxel;
      if (has_voxels_ && !tile.voxels.insert(voxel[0], voxel[1], voxel[2])) continue;
      const auto offset = tile.pending.size();
      tile.pending.resize(offset + record_size_);
      std::memcpy(tile.pending.data() + offset, point.position.data(), kPositionSize);
      record_map.copy(records + point.source * source_size, tile.pending.data() + offset + kPositionSize);
      ++num_added;
    }
    num_pending_bytes_ += tile.pending.size() - size_before;
    num_points_ += (tile.pending.size() - size_before) / record_size_;
  }
  return num_added;
}

TileWriter::OpenTile& TileWriter::open(const TileIndex& index) {
  auto found = open_tiles_.find(index);
  if (found == open_tiles_.end()) {
    if (open_tiles_.size() >= max_open_tiles_) closeLeastRecentlyUsed();
    auto tile = std::make_unique<OpenTile>();
    if (has_voxels_) tile->voxels = savedVoxels(index);
    found = open_tiles_.emplace(index, std::move(tile)).first;
  }
  found->second->last_used = ++num_uses_;
  return *found->second;
}

VoxelSet TileWriter::savedVoxels(const TileIndex& index) const {
  VoxelSet voxels;
  const auto saved = num_saved_.find(index);
  if (saved == num_saved_.end()) return voxels;
  const std::uint64_t num_points = std::min(saved->second, countTileRecords(directory_, index, fields_));
  const auto bytes = readTileColumns(directory_, {index, num_points}, fields_, 0, kPositionSize);
  for (std::size_t offset = 0; offset < bytes.size(); offset += kPositionSize) {
    std::array<float, 3> position{};
    std::memcpy(position.data(), bytes.data() + offset, kPositionSize);
    const auto cell = grid_.cellOf(position.data());
    if (cell.tile == index) voxels.insert(cell.voxel[0], cell.voxel[1], cell.voxel[2]);
  }
  return voxels;
}

void TileWriter::closeLeastRecentlyUsed() {
  auto oldest = open_tiles_.end();
  for (auto it = open_tiles_.begin(); it != open_tiles_.end(); ++it) {
    if (oldest == open_tiles_.end() || it->second->last_used < oldest->second->last_used) oldest = it;
  }
  save(oldest->first, *oldest->second);
  open_tiles_.erase(oldest);
}

void TileWriter::save(const TileIndex& index, OpenTile& tile) {
  if (tile.pending.empty()) return;
  auto& num_saved = num_saved_[index];
  before_growth_(index, num_saved);
  const std::uint64_t num_in_file = appendToTile(directory_, index, fields_, num_saved, tile.pending);
  num_points_ -= num_saved + tile.pending.size() / record_size_ - num_in_file;  // what something has cut off
  num_saved = num_in_file;
  num_pending_bytes_ -= tile.pending.size();
  tile.pending.clear();
}

void TileWriter::flush() {
  for (auto& [index, tile] : open_tiles_) save(index, *tile);
}

}  // namespace cloud_colorizer
