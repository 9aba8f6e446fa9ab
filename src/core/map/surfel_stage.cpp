// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cmath>
#include <memory>
#include <vector>

#include "base/parallel.hpp"
#include "base/progress.hpp"
#include "map/fingerprint.hpp"
#include "map/lru_cache.hpp"
#include "map/memory_plan.hpp"
#include "map/stages.hpp"
#include "recording/tile_range.hpp"
#include "visibility/moving.hpp"

namespace cloud_colorizer {
namespace {

/// The largest cells that surfels come from are this part of a tile, and twice as much of the tiles beside it is
/// needed: a neighbourhood, and what is around it.
constexpr int kCellsPerTile = 16;

/// The points of tiles, those used last kept.
class TilePoints {
 public:
  TilePoints(const Recording& recording, double memory_limit)
      : recording_(recording),
        points_(
            MemoryPlan(memory_limit).surfaces(), [this](std::size_t tile) { return recording_.readPoints(tile); },
            [](const Points& points) { return static_cast<std::size_t>(points.size()) * sizeof(float); }) {}

  std::shared_ptr<const Points> of(std::size_t tile) { return points_.get(tile); }

  /// Those of a tile first, then those of the tiles beside it that lie within `margin` [m].
  Points around(std::size_t tile, float margin) {
    const auto own = points_.get(tile);
    Eigen::AlignedBox3f box = recording_.tileBox(tile);
    box.min().array() -= margin, box.max().array() += margin;
    std::vector<Eigen::Vector3f> beside;
    for (const std::size_t other : tilesAround(recording_.tiles(), recording_.tileSize(), box.cast<double>())) {
      if (other == tile || !recording_.tileBox(other).intersects(box)) continue;
      const auto points = points_.get(other);
      for (Eigen::Index i = 0; i < points->cols(); ++i) {
        if (box.contains(points->col(i))) beside.emplace_back(points->col(i));
      }
    }
    Points all(3, own->cols() + static_cast<Eigen::Index>(beside.size()));
    all.leftCols(own->cols()) = *own;
    for (std::size_t i = 0; i < beside.size(); ++i) all.col(own->cols() + static_cast<Eigen::Index>(i)) = beside[i];
    return all;
  }

 private:
  const Recording& recording_;
  LruCache<Points> points_;
};

/// Of a tile, as it lies in the map. All tiles have the same cells.
Surfels surfelsOfTile(const Recording& recording, std::size_t tile, TilePoints& source, const SurfelParams& params) {
  constexpr int kBits = kZOrderBits - 1;  // of a tile; the grid reaches half a tile beyond it
  const auto side = static_cast<float>(recording.tileSize());
  const ZOrderGrid grid{recording.tileBox(tile).min().array() - side / 2, std::ldexp(side, -kBits)};
  const auto num_own = static_cast<Eigen::Index>(recording.tiles()[tile].num_points);
  static_assert((kCellsPerTile & (kCellsPerTile - 1)) == 0, "a cell does not cross the border of a tile");
  return estimateSurfels(source.around(tile, 2 * side / kCellsPerTile), num_own, grid,
                         kBits - static_cast<int>(std::log2(kCellsPerTile)), params);
}

/// A van that drove ahead left a trail of points that hides the street. Where a camera has been, nothing stays: points
/// there are of something that moved, and hide nothing.
void clearPath(const Recording& recording, std::size_t tile, double clear_radius, PointsRef points, Surfels& surfels) {
  const auto radius = static_cast<float>(clear_radius);
  std::vector<Eigen::Vector3f> places;
  for (const View& view : recording.views()) {
    const Eigen::Vector3f place = view.map_from_camera.translation().cast<float>();
    if (recording.tileBox(tile).exteriorDistance(place) < radius) places.push_back(place);
  }
  for (Eigen::Index i = 0; i < points.cols() && !places.empty(); ++i) {
    const auto isNear = [&](const Eigen::Vector3f& p) { return (p - points.col(i)).squaredNorm() < radius * radius; };
    if (std::any_of(places.begin(), places.end(), isNear)) surfels.radii[i] = -surfels.radii[i];
  }
}

/// What moved was there at its own moment only.
void markMoving(const std::vector<std::uint8_t>& shares, Surfels& surfels) {
  for (std::size_t i = 0; i < shares.size(); ++i) {
    if (shares[i] < kMovingShare) continue;
    float& radius = surfels.radii[static_cast<Eigen::Index>(i)];
    radius = -std::abs(radius);
  }
}

}  // namespace

void makeSurfels(Workspace& work, const Callbacks& callbacks) {
  const Recording& recording = work.recording();
  const DerivedFiles& files = work.files();
  files.claim(kSurfelsFolder, surfelsKey(recording, work.params()));
  ProgressMeter progress(callbacks, "surfels", recording.numPoints());
  TilePoints source(recording, work.params().colorize.memory_limit);
  parallelFor(work.params().colorize.num_threads, recording.tiles().size(), [&](std::size_t tile) {
    const bool todo = !files.hasSurfels(tile);
    if (todo) {
      Surfels surfels = surfelsOfTile(recording, tile, source, work.params().surfels);
      clearPath(recording, tile, work.params().depth.clear_radius, *source.of(tile), surfels);
      if (findsMoving(recording, work.params())) markMoving(files.readMoving(tile), surfels);
      files.writeSurfels(tile, surfels);
    }
    progress.add(recording.tiles()[tile].num_points, todo);
  });
}

}  // namespace cloud_colorizer
