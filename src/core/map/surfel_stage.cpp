// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cmath>
#include <map>
#include <memory>
#include <vector>

#include "base/parallel.hpp"
#include "base/progress.hpp"
#include "map/fingerprint.hpp"
#include "map/lru_cache.hpp"
#include "map/stages.hpp"
#include "map/tile_blocks.hpp"
#include "recording/tile_range.hpp"
#include "visibility/moving.hpp"

namespace cloud_colorizer {
namespace {

/// The largest cells that surfels come from are this part of a block of tiles, and twice as much of the tiles beside is
/// needed: a neighbourhood, and what is around it.
constexpr int kCellsPerBlock = 16;
constexpr int kBits = kZOrderBits - 1;       // of a block; its grid reaches half a block beyond it
constexpr std::size_t kMostPoints = 400000;  // of several tiles at once

/// Tiles whose surfels are made together, as most of what lies around one of them is in the others.
using Unit = TileIds;

Eigen::AlignedBox3f boxOf(const Recording& recording, const Unit& unit) {
  Eigen::AlignedBox3f box;
  for (const std::size_t tile : unit) box.extend(recording.tileBox(tile));
  return box;
}

/// The points of tiles, those used last kept.
class TilePoints {
 public:
  TilePoints(const Recording& recording, std::size_t max_bytes)
      : recording_(recording),
        points_(
            max_bytes, [this](std::size_t tile) { return recording_.readPoints(tile); },
            [](const Points& points) { return static_cast<std::size_t>(points.size()) * sizeof(float); }) {}

  std::shared_ptr<const Points> of(std::size_t tile) { return points_.get(tile); }

  /// Those of some tiles, one after the other, then what lies within `margin` [m] of the box around them.
  Points around(const Unit& tiles, float margin) {
    Eigen::AlignedBox3f box = boxOf(recording_, tiles);
    const auto num_own = static_cast<Eigen::Index>(countPoints(recording_.tiles(), tiles));
    box.min().array() -= margin, box.max().array() += margin;
    std::vector<Eigen::Vector3f> beside;
    for (const std::size_t other : tilesAround(recording_.tiles(), recording_.tileSize(), box.cast<double>())) {
      if (std::binary_search(tiles.begin(), tiles.end(), other) || !recording_.tileBox(other).intersects(box)) continue;
      const auto points = points_.get(other);
      for (Eigen::Index i = 0; i < points->cols(); ++i) {
        if (box.contains(points->col(i))) beside.emplace_back(points->col(i));
      }
    }
    Points all(3, num_own + static_cast<Eigen::Index>(beside.size()));
    Eigen::Index next = 0;
    for (const std::size_t tile : tiles) {
      const auto own = points_.get(tile);
      all.middleCols(next, own->cols()) = *own;
      next += own->cols();
    }
    for (std::size_t i = 0; i < beside.size(); ++i) all.col(num_own + static_cast<Eigen::Index>(i)) = beside[i];
    return all;
  }

 private:
  const Recording& recording_;
  LruCache<Points> points_;
};

/// Of the points of a unit, as it lies in the map. All units have the same cells.
Surfels surfelsOf(const Recording& recording, const Unit& unit, const ZOrderGrid& grid, TilePoints& source,
                  const SurfelParams& params) {
  const auto num_own = static_cast<Eigen::Index>(countPoints(recording.tiles(), unit));
  static_assert((kCellsPerBlock & (kCellsPerBlock - 1)) == 0, "a cell does not cross the border of a block");
  const auto margin = static_cast<float>(2 * blockSize(recording) / kCellsPerBlock);
  return estimateSurfels(source.around(unit, margin), num_own, grid,
                         kBits - static_cast<int>(std::log2(kCellsPerBlock)), params);
}

ZOrderGrid gridOf(const Recording& recording, const Unit& unit) {
  const auto side = static_cast<float>(blockSize(recording));
  // Where tiles are missing the box is smaller, but its corner is one of a tile, and so of a largest cell.
  return {boxOf(recording, unit).min().array() - side / 2, std::ldexp(side, -kBits)};
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

std::vector<Unit> surfelUnits(const Recording& recording) {
  return cubesOfTiles(recording, allTiles(recording.tiles()), kMostPoints, tilesPerBlock(recording));
}

std::vector<double> pointsOfUnits(const Workspace& work) {
  std::vector<double> points;
  for (const Unit& unit : surfelUnits(work.recording())) {
    points.push_back(static_cast<double>(countPoints(work.recording().tiles(), unit)));
  }
  return points;
}

UnitFiles surfelFiles(const Workspace& work) {
  UnitFiles files;
  for (const Unit& unit : surfelUnits(work.recording()))
    files.push_back(work.files().namesOfTiles(unit, kThinnedExtension));
  return files;
}

void makeSurfels(Workspace& work, UnitRange range, const Callbacks& callbacks) {
  const Recording& recording = work.recording();
  const DerivedFiles& files = work.files();
  const std::vector<Unit> units = surfelUnits(recording);
  std::size_t num_points = 0;
  for (std::size_t u = range.first; u < range.last; ++u) num_points += countPoints(recording.tiles(), units[u]);
  ProgressMeter progress(callbacks, "surfels", num_points);
  TilePoints source(recording, work.memory().surfaces());
  parallelFor(work.params().colorize.num_threads, range.size(), [&](std::size_t k) {
    const Unit& unit = units[range.first + k];
    const bool todo = !std::all_of(unit.begin(), unit.end(), [&](std::size_t tile) { return files.hasSurfels(tile); });
    const ZOrderGrid grid = gridOf(recording, unit);
    const Surfels surfels = todo ? surfelsOf(recording, unit, grid, source, work.params().surfels) : Surfels{};
    Eigen::Index next = 0;
    for (const std::size_t tile : unit) {
      const auto count = static_cast<Eigen::Index>(recording.tiles()[tile].num_points);
      if (todo) {
        Surface surface{*source.of(tile), surfels.segment(next, count)};
        clearPath(recording, tile, work.params().depth.clear_radius, surface.points, surface.surfels);
        if (findsMoving(recording, work.params())) markMoving(files.readMoving(tile), surface.surfels);
        files.writeSurfels(tile, surface.surfels, thinSurface(surface, grid));
      }
      next += count;
      progress.add(static_cast<std::size_t>(count), todo);
    }
  });
}

}  // namespace

Stage surfelStage() {
  return {
      "surfels",   "blocks of tiles", kSurfelsFolder,
      {"moving"},  pointsOfUnits,     [](const Workspace& work) { return surfelsKey(work.recording(), work.params()); },
      surfelFiles, makeSurfels,       {}};
}

}  // namespace cloud_colorizer
