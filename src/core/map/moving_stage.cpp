// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause
#include "base/parallel.hpp"
#include "base/progress.hpp"
#include "map/fingerprint.hpp"
#include "map/stages.hpp"
#include "visibility/moving.hpp"

namespace cloud_colorizer {
namespace {

constexpr std::size_t kMaxScans = 96;  // vote on a tile: more take time and change few votes

/// Scans whose sensor may have reached the tile, at even steps of time.
std::vector<std::size_t> scansInReach(const Recording& recording, std::size_t tile, double max_range) {
  std::vector<std::size_t> near;
  for (std::size_t scan = 0; scan < recording.scans().size(); ++scan) {
    const Eigen::Vector3f place = recording.scans()[scan].map_from_sensor.translation().cast<float>();
    if (recording.tileBox(tile).exteriorDistance(place) < max_range) near.push_back(scan);
  }
  const std::size_t count = std::min(near.size(), kMaxScans);
  std::vector<std::size_t> taken(count);
  for (std::size_t k = 0; k < count; ++k) taken[k] = near[k * near.size() / count];
  return taken;
}

std::vector<std::uint8_t> vote(Workspace& work, std::size_t tile) {
  const Recording& recording = work.recording();
  const Points points = recording.readPoints(tile);
  MovingVotes votes(recording.tiles()[tile].num_points);
  for (const std::size_t scan : scansInReach(recording, tile, work.params().record.max_range)) {
    const Eigen::Isometry3d sensor_from_map = recording.scans()[scan].map_from_sensor.inverse();
    votes.add({work.scan(scan), sensor_from_map.cast<float>()}, points);
  }
  return votes.shares();
}

std::vector<double> movingUnits(const Workspace& work) {
  std::vector<double> units;
  if (!findsMoving(work.recording(), work.params())) return units;
  for (const Tile& tile : work.recording().tiles()) units.push_back(static_cast<double>(tile.num_points));
  return units;
}

UnitFiles movingFiles(const Workspace& work) {
  UnitFiles files;
  for (std::size_t tile = 0; tile < work.recording().tiles().size(); ++tile) {
    files.push_back({work.files().nameOfTile(tile)});
  }
  return files;
}

void findMoving(Workspace& work, UnitRange units, const Callbacks& callbacks) {
  const std::vector<Tile>& tiles = work.recording().tiles();
  const DerivedFiles& files = work.files();
  std::size_t num_points = 0;
  for (std::size_t tile = units.first; tile < units.last; ++tile) num_points += tiles[tile].num_points;
  ProgressMeter progress(callbacks, "moving things", num_points);
  parallelFor(work.params().colorize.num_threads, units.size(), [&](std::size_t k) {
    const std::size_t tile = units.first + k;
    const bool todo = !files.hasMoving(tile);
    if (todo) files.writeMoving(tile, vote(work, tile));
    progress.add(tiles[tile].num_points, todo);
  });
}

}  // namespace

Stage movingStage() {
  return {"moving",    "tiles",     kMovingFolder,
          {},          movingUnits, [](const Workspace& work) { return movingKey(work.recording(), work.params()); },
          movingFiles, findMoving,  {}};
}

}  // namespace cloud_colorizer
