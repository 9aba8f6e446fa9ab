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

}  // namespace

void findMoving(Workspace& work, const Callbacks& callbacks) {
  const Recording& recording = work.recording();
  if (!findsMoving(recording, work.params())) return;
  const DerivedFiles& files = work.files();
  files.claim(kMovingFolder, movingKey(recording, work.params()));
  ProgressMeter progress(callbacks, "moving things", recording.numPoints());
  parallelFor(work.params().colorize.num_threads, recording.tiles().size(), [&](std::size_t tile) {
    const bool todo = !files.hasMoving(tile);
    if (todo) files.writeMoving(tile, vote(work, tile));
    progress.add(recording.tiles()[tile].num_points, todo);
  });
}

}  // namespace cloud_colorizer
