// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "base/parallel.hpp"
#include "base/progress.hpp"
#include "cloud_colorizer/color/point_colors.hpp"
#include "cloud_colorizer/map/chunks.hpp"
#include "color/appearance.hpp"
#include "color/held_out.hpp"
#include "map/fingerprint.hpp"
#include "map/memory_budget.hpp"
#include "map/memory_plan.hpp"
#include "map/quantities.hpp"
#include "map/stages.hpp"

namespace cloud_colorizer {
namespace {

using Eigen::Index;

/// The points of a chunk: its core tiles one after the other, then what lies in its halo.
Surface gatherChunk(Workspace& work, const Chunk& chunk) {
  std::vector<Surface> parts;
  for (const std::size_t tile : chunk.core_tiles) parts.push_back(*work.surface(tile));
  for (const std::size_t tile : chunk.halo_tiles) {
    const auto surface = work.surface(tile);
    std::vector<Index> inside;
    for (Index i = 0; i < surface->size(); ++i) {
      if (chunk.box_with_halo.contains(surface->points.col(i))) inside.push_back(i);
    }
    if (!inside.empty()) parts.push_back(gatherSurface(*surface, inside));
  }
  return concatenate(parts);
}

/// One grid for the whole map, so that a point in two chunks has the same place in the order.
ZOrderGrid globalGrid(const Recording& recording) {
  const double tile_size = recording.tileSize();
  Eigen::AlignedBox3d box;
  for (const Tile& tile : recording.tiles()) {
    const Eigen::Vector3d low = Eigen::Vector3d(tile.index[0], tile.index[1], tile.index[2]) * tile_size;
    box.extend(low).extend(low + Eigen::Vector3d::Constant(tile_size));
  }
  const double extent = box.sizes().maxCoeff() + 2 * tile_size;
  ZOrderGrid grid;
  grid.origin = (box.min() - Eigen::Vector3d::Constant(tile_size)).cast<float>();
  grid.cell = static_cast<float>(std::ldexp(extent, -kZOrderBits + 1));
  return grid;
}

/// Where the points of each core tile are in Z-order: point order[k] of those gathered is at k.
std::vector<std::vector<Index>> coreColumns(const Workspace& work, const Chunk& chunk,
                                            const std::vector<Index>& order) {
  std::vector<Index> column_of(order.size());
  for (std::size_t k = 0; k < order.size(); ++k) column_of[static_cast<std::size_t>(order[k])] = static_cast<Index>(k);
  std::vector<std::vector<Index>> columns;
  auto next = column_of.begin();
  for (const std::size_t tile : chunk.core_tiles) {
    const auto end = next + static_cast<std::ptrdiff_t>(work.recording().tiles()[tile].num_points);
    columns.emplace_back(next, end);
    next = end;
  }
  return columns;
}

/// What the nearest view of each point shows, in its own exposure.
struct NearestViews {
  std::vector<std::array<std::uint8_t, 3>> values;
  std::vector<std::uint8_t> cameras;
};

NearestViews nearestViews(const Workspace& work, const Observations& observations) {
  const std::vector<std::uint32_t> nearest = nearestObservations(observations);
  NearestViews shown{std::vector<std::array<std::uint8_t, 3>>(nearest.size()),
                     std::vector<std::uint8_t>(nearest.size())};
  for (std::size_t p = 0; p < nearest.size(); ++p) {
    if (nearest[p] == observations.numObservations()) continue;
    const std::uint32_t view = observations.views[nearest[p]];
    const Eigen::ArrayXf& gain = work.corrections()[view].exposure.gain;
    for (Index channel = 0; channel < 3; ++channel) {
      const Index row = std::min(channel, observations.values.rows() - 1);  // of a grey image
      const float value = observations.values(row, nearest[p]) / (row < gain.size() ? gain[row] : 1.F);
      shown.values[p][static_cast<std::size_t>(channel)] =
          static_cast<std::uint8_t>(std::clamp(std::lround(value), 0L, 255L));
    }
    shown.cameras[p] = static_cast<std::uint8_t>(std::min(work.recording().views()[view].camera, 255U));
  }
  return shown;
}

SightPlace sightPlace(const Workspace& work, std::uint32_t view, const Eigen::Vector3f& point) {
  const Camera& camera = work.cameraOf(view);
  const Eigen::Isometry3f camera_from_map = work.corrections()[view].map_from_camera.inverse().cast<float>();
  SightPlace sight{work.recording().views()[view].camera, {0, 0}};
  if (const auto pixel = camera.project(camera_from_map * point)) {
    const Intrinsics& k = camera.intrinsics();
    sight.place = pixel->cwiseQuotient(Eigen::Vector2i(k.width, k.height).cast<float>());
  }
  return sight;
}

/// The colours without sheen, and how much of it there is.
struct Diffuse {
  Eigen::Matrix3Xf values;  ///< empty where nobody asked
  std::vector<std::uint8_t> specular;
};

/// Takes the sheen out of the observations, or nothing where nobody asked.
Sheen takeOutSheen(const Workspace& work, const Surface& surface, Observations& observations) {
  const Appearance appearance = work.params().colorize.appearance;
  if (appearance == Appearance::kNone) return {};
  std::vector<Eigen::Vector3f> eyes;
  for (const CorrectedView& view : work.corrections()) {
    eyes.emplace_back(view.map_from_camera.translation().cast<float>());
  }
  const Sights sights{surface.points, surface.surfels.normals, observations, eyes};
  return takeOutSheen(sights, appearance, static_cast<float>(sheenCellSize(work.recording())), observations);
}

/// The colours become what is seen of each point on an average of its views.
Diffuse separated(const Sheen& sheen, Fused& colors) {
  Diffuse diffuse;
  if (sheen.mean.cols() == 0) return diffuse;
  diffuse.values = Eigen::Matrix3Xf::Zero(3, colors.values.cols());
  diffuse.specular.assign(static_cast<std::size_t>(colors.values.cols()), 0);
  for (Index p = 0; p < colors.values.cols(); ++p) {
    if (colors.count[p] == 0) continue;
    const float without = colors.values.col(p).sum();
    const float least = without + sheen.least.col(p).sum(), most = without + sheen.most.col(p).sum();
    const float share = most > 0 ? std::clamp((most - least) / most, 0.F, 1.F) : 0;
    diffuse.specular[static_cast<std::size_t>(p)] = static_cast<std::uint8_t>(std::lround(255 * share));
    for (Index c = 0; c < 3; ++c) {
      diffuse.values(c, p) = std::max(0.F, colors.values(c, p) + sheen.least(c, p));
      colors.values(c, p) += sheen.mean(c, p);
    }
  }
  return diffuse;
}

TileColors gatherColors(const Fused& colors, const std::vector<Unseen>& unseen, const NearestViews& nearest,
                        const Diffuse& diffuse, const Values& quantities, const std::vector<Index>& columns) {
  TileColors tile{gatherColumns(colors.values, columns).cwiseMax(0.F), {}, {}, {}, {}, {}, {}, {}, {}};
  if (quantities.rows() > 0) tile.quantities = gatherColumns(quantities, columns);
  if (diffuse.values.cols() > 0) {
    tile.diffuse = gatherColumns(diffuse.values, columns);
    for (const Index k : columns) tile.specular.push_back(diffuse.specular[static_cast<std::size_t>(k)]);
  }
  for (const Index k : columns) {
    tile.count.push_back(static_cast<std::uint16_t>(std::min(colors.count[k], 65535)));
    tile.stddev.push_back(colors.stddev[k]);
    tile.unseen.push_back(unseen[static_cast<std::size_t>(k)]);
    tile.nearest.push_back(nearest.values[static_cast<std::size_t>(k)]);
    tile.camera.push_back(nearest.cameras[static_cast<std::size_t>(k)]);
  }
  return tile;
}

/// The views of a chunk: of good ones that come first, the others are found worse at a glance.
std::vector<std::size_t> nearestFirst(const Workspace& work, const Chunk& chunk, const Quantity& quantity = {}) {
  std::vector<std::size_t> views = work.viewsOf(chunk.box_with_halo, quantity);
  const Eigen::Vector3d center = chunk.box_with_halo.center().cast<double>();
  const auto distance = [&](std::size_t view) {
    return (work.corrections()[view].map_from_camera.translation() - center).squaredNorm();
  };
  std::stable_sort(views.begin(), views.end(), [&](auto a, auto b) { return distance(a) < distance(b); });
  return views;
}

void colorChunk(Workspace& work, const Chunk& chunk, const ZOrderGrid& grid) {
  Surface surface = gatherChunk(work, chunk);
  // In Z-order, what is near in space is near in memory: several times faster gradients and factorisation.
  const auto sorted = zorderSort(zorderKeys(surface.points, grid), zorderMask(0));
  const std::vector<Index> order(sorted.begin(), sorted.end());
  surface = gatherSurface(surface, order);

  const std::vector<std::size_t> views = nearestFirst(work, chunk);
  const auto viewAt = [&](std::size_t k) { return work.observedView(views[k]); };
  const Params& params = work.params();
  ObserveResult seen = observe(surface.points, surface.surfels, views.size(), viewAt, params.depth, params.observe);
  const NearestViews nearest = nearestViews(work, seen.observations);
  const Sheen sheen = takeOutSheen(work, surface, seen.observations);
  const auto core_columns = coreColumns(work, chunk, order);
  const double cell = toneCellSize(work.recording());
  const auto placeOf = [&](std::uint32_t view, const Eigen::Vector3f& point) { return sightPlace(work, view, point); };
  std::vector<TileViews> of_views;
  of_views.reserve(core_columns.size());
  for (const auto& columns : core_columns) {
    of_views.push_back({countViews(surface.points, columns, seen.observations, cell),
                        leaveOneOut(surface.points, columns, seen.observations, placeOf)});
  }
  Fused colors = colorPoints(surface.points, std::move(seen.observations), grid, params.colorize.method, params.graph,
                             params.system);
  // Without a view nothing tells the number of channels.
  if (views.empty()) colors.values = Values::Zero(3, surface.size());
  const Diffuse diffuse = separated(sheen, colors);
  const SeenQuantities quantities =
      seeQuantities(work, surface, grid, [&](const Quantity& quantity) { return nearestFirst(work, chunk, quantity); });
  if (!work.recording().hasColors()) {
    seen.unseen = quantities.unseen;
    colors.count = quantities.count;
  }
  for (std::size_t i = 0; i < core_columns.size(); ++i) {
    const TileColors tile = gatherColors(colors, seen.unseen, nearest, diffuse, quantities.fields, core_columns[i]);
    addPeaks(gatherColumns(surface.points, core_columns[i]), tile.values, cell, of_views[i].tone);
    work.files().writeColors(chunk.core_tiles[i], tile, of_views[i]);
  }
}

std::vector<Chunk> chunksOf(const Workspace& work) {
  return planChunks(work.recording().tiles(), work.recording().tileSize(), work.params().chunks);
}

std::vector<double> pointsOfChunks(const Workspace& work) {
  std::vector<double> points;
  for (const Chunk& chunk : chunksOf(work)) points.push_back(chunk.num_points_with_halo);
  return points;
}

UnitFiles chunkFiles(const Workspace& work) {
  UnitFiles files;
  for (const Chunk& chunk : chunksOf(work)) {
    files.push_back(work.files().namesOfTiles(chunk.core_tiles, kViewsExtension));
  }
  return files;
}

void colorChunks(Workspace& work, UnitRange units, const Callbacks& callbacks) {
  const Recording& recording = work.recording();
  const Params& params = work.params();
  std::vector<Chunk> chunks = chunksOf(work);
  chunks = {chunks.begin() + static_cast<std::ptrdiff_t>(units.first),
            chunks.begin() + static_cast<std::ptrdiff_t>(units.last)};
  // Large ones first, so that no thread is left with one at the end.
  std::stable_sort(chunks.begin(), chunks.end(),
                   [](const Chunk& a, const Chunk& b) { return a.num_points_with_halo > b.num_points_with_halo; });
  const ZOrderGrid grid = globalGrid(recording);
  const DerivedFiles& files = work.files();
  std::size_t num_points = 0;
  for (const Chunk& chunk : chunks) num_points += chunk.num_core_points;
  MemoryBudget memory(static_cast<double>(work.memory().chunks()));
  ProgressMeter progress(callbacks, "colour", num_points);
  parallelFor(params.colorize.num_threads, chunks.size(), [&](std::size_t c) {
    const auto& tiles = chunks[c].core_tiles;
    const bool todo = !std::all_of(tiles.begin(), tiles.end(), [&](std::size_t tile) { return files.hasColors(tile); });
    if (todo) {
      const MemoryBudget::Share share(memory, MemoryPlan::chunkBytes(chunks[c].num_points_with_halo));
      colorChunk(work, chunks[c], grid);
    }
    progress.add(chunks[c].num_core_points, todo);
  });
}

}  // namespace

Stage colorStage() {
  return {"chunks",
          "chunks",
          kColorsFolder,
          {"images", "moving", "surfels", "alignment", "depth"},
          pointsOfChunks,
          [](const Workspace& work) {
            return colorsKey(work.recording(), work.params(), work.damagedViews(), work.corrections());
          },
          chunkFiles,
          colorChunks,
          {}};
}

}  // namespace cloud_colorizer
