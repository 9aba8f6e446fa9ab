// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause
#include "map/fill.hpp"

#include <algorithm>
#include <cmath>

#include "base/columns.hpp"
#include "recording/tile_range.hpp"
#include "surface/kdtree.hpp"

namespace cloud_colorizer {
namespace {

using Eigen::Index;

struct Colored {
  Points points;
  Values values;
};

void append(Colored& all, const Points& points, const TileColors& colors, const Eigen::AlignedBox3f& box) {
  std::vector<Index> taken;
  for (Index i = 0; i < points.cols(); ++i) {
    if (colors.count[static_cast<std::size_t>(i)] > 0 && box.contains(points.col(i))) taken.push_back(i);
  }
  const Index before = all.points.cols(), added = static_cast<Index>(taken.size());
  all.points.conservativeResize(3, before + added);
  all.values.conservativeResize(3, before + added);
  all.points.rightCols(added) = gatherColumns(points, taken);
  all.values.rightCols(added) = gatherColumns(colors.values, taken);
}

/// The coloured points in and around a tile.
Colored coloredAround(const Workspace& work, std::size_t tile, const Points& points, const TileColors& colors) {
  const auto distance = static_cast<float>(work.params().colorize.fill_distance);
  const Eigen::Vector3f margin = Eigen::Vector3f::Constant(distance);
  Eigen::AlignedBox3f box = work.recording().tileBox(tile);
  box = {box.min() - margin, box.max() + margin};
  Colored around{Points(3, 0), Values(3, 0)};
  const Recording& recording = work.recording();
  for (const std::size_t other : tilesAround(recording.tiles(), recording.tileSize(), box.cast<double>())) {
    if (other == tile) {
      append(around, points, colors, box);
    } else if (recording.tileBox(other).intersects(box)) {
      append(around, recording.readPoints(other), work.files().readColors(other), box);
    }
  }
  return around;
}

}  // namespace

void fillUncolored(const Workspace& work, std::size_t tile, TileColors& colors) {
  if (std::find(colors.count.begin(), colors.count.end(), 0) == colors.count.end()) return;
  const Points points = work.recording().readPoints(tile);
  const Colored around = coloredAround(work, tile, points, colors);
  if (around.points.cols() == 0) return;
  const KdTree tree(around.points);
  const auto limit = static_cast<float>(std::pow(work.params().colorize.fill_distance, 2));
  std::uint32_t nearest = 0;
  float squared_distance = 0;
  for (Index i = 0; i < points.cols(); ++i) {
    if (colors.count[static_cast<std::size_t>(i)] > 0) continue;
    tree.nearest(points.col(i), 1, &nearest, &squared_distance);
    if (squared_distance > limit) continue;
    colors.values.col(i) = around.values.col(nearest);
    if (colors.diffuse.cols() > 0) colors.diffuse.col(i) = around.values.col(nearest);
  }
}

}  // namespace cloud_colorizer
