// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause
#include "cloud_colorizer/surface/surfels.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

#include "cloud_colorizer/base/check.hpp"
#include "surface/cell_patches.hpp"
#include "surface/distinct.hpp"

namespace cloud_colorizer {
namespace {

using Eigen::Index;

constexpr float kFlat = 0.05F;         // ratio of variances below which a neighbourhood is a surface at its scale
constexpr float kFlatEnough = 0.35F;   // the same where no scale has a flat one
constexpr int kMaxGrowth = 4;          // levels above the first with enough points
constexpr float kDeviations = 3;       // of the thickness: farther from the surface a point is not part of it,
constexpr float kOwnShare = 0.5F;      // with this share of a cell added where it is the surface of its cell,
constexpr float kBesideShare = 0.1F;   // and this where it lies beside
constexpr float kFill = 0.4F;          // of the density at the first level: less of it is no slab but structure
constexpr float kLineWidth = 1.5F;     // of a line's own width, which a surface across lines may be thick
constexpr float kLineShare = 0.05F;    // of a cell, besides
constexpr float kThinShare = 0.5F;     // of the points around: where so many are flat at a finer level, the map is thin
constexpr int kBeyond = 4;             // levels above a flat neighbourhood at which layers beside it are looked for,
constexpr float kParallel = 0.9F;      // where the normals' cosine is above this
constexpr float kAveraged = 0.5F;      // of the scatter of points: what is left in a surface through many of them
constexpr float kBallScatter = 2;      // of the least deviation of points that are no surface
constexpr float kClosing = 1.1F;       // spacings: discs of 0.71 close a square grid; half as much again if irregular
constexpr float kAcrossLines = 0.75F;  // of a cell: reaches from scan line to scan line
constexpr float kSparse = 3;           // lines are sparser across than the mean spacing by at most this factor
constexpr float kBall = 0.4F;          // of a cell, where there is no surface

Surfels noSurfels(Index n) {
  return {Eigen::Matrix3Xf::Zero(3, n), Eigen::VectorXf::Zero(n), Eigen::VectorXf::Zero(n), Eigen::VectorXf::Zero(n)};
}

/// The level at which some cell first holds `count` points; at most `max_level`.
int firstLevel(const std::vector<std::uint64_t>& keys, std::size_t count, int max_level) {
  int level = max_level;
  for (std::size_t i = count - 1; i < keys.size(); ++i) {
    const std::uint64_t differing = keys[i] ^ keys[i + 1 - count];
    level = std::min(level, differing == 0 ? 0 : (63 - __builtin_clzll(differing)) / 3 + 1);
  }
  return level;
}

/// Goes through the levels from fine to coarse, until every point has its surfel. A neighbourhood grows only where the
/// points fill a slab that is thicker than they are apart; where they are an edge, a pole or leaves, a larger one would
/// flatten what is really there.
class Estimator {
 public:
  Estimator(const Distinct& distinct, const ZOrderGrid& grid, int max_level, const SurfelParams& params)
      : points_(distinct.points),
        grid_(grid),
        max_level_(max_level),
        min_count_(static_cast<std::uint32_t>(params.num_neighbors)),
        states_(distinct.keys.size()),
        surfels_(noSurfels(distinct.points.cols())) {
    // A cell and those around it have enough points only where some cell twice as large has half of them.
    const int first = firstLevel(distinct.keys, min_count_ / 2, max_level);
    CellLevel level(points_, distinct.keys, grid, std::max(0, first - 1));
    while (true) {
      estimate(level);
      if (level.level() >= max_level) return;
      level = level.parents();
    }
  }

  /// Once: with what the layers add to the thicknesses.
  Surfels finish() {
    for (std::size_t i = 0; i < states_.size(); ++i) {
      const auto at = static_cast<Index>(i);
      if (surfels_.normals.col(at).isZero()) continue;
      const float own = (states_[i].ratio < kFlat ? kAveraged : 1) * surfels_.thicknesses[at];
      surfels_.thicknesses[at] = std::sqrt(own * own + states_[i].layers);
    }
    return std::move(surfels_);
  }

 private:
  struct State {
    bool open = true;
    std::int8_t first = -1;     ///< level with enough points
    std::int8_t settled = -1;   ///< level at which it was closed
    float layers = 0;           ///< m^2, variance of the layers beside its surface
    float ratio = kFlatEnough;  ///< of the best patch so far
    float density = 0;          ///< at the first level, points a cubic cell of the grid
    float line_width = -1;      ///< at the first level where it is a line, m; else negative
  };
  /// What is known of the points of a cell from finer levels.
  struct Settled {
    float count = 0, variance = 0;
  };

  void estimate(const CellLevel& level) {
    CellPatches patches(level, static_cast<float>(min_count_));
    CellNeighbors neighbors(level);
    const std::vector<Settled> settled = settledIn(level);
    for (std::size_t cell = 0; cell < level.size(); ++cell) {
      lookBeyond(level, cell, patches);
      if (!isOpen(level, cell)) continue;
      neighbors.moveTo(cell);
      const float count = countAround(level, neighbors);
      if (count < static_cast<float>(min_count_) && level.level() < max_level_) continue;  // as at all finer levels
      const Settled around = settledAround(neighbors, settled);
      if (around.count > kThinShare * count) closeThin(level, cell, around);
      takeAll(level, cell, neighbors, patches);
    }
  }

  /// Where poses drift, a wall is several layers, each flat at its own scale. A larger neighbourhood that is flat as
  /// well has them all: what it scatters more is how far they are apart.
  void lookBeyond(const CellLevel& level, std::size_t cell, CellPatches& patches) {
    for (std::uint32_t i = level.begin(cell); i < level.end(cell); ++i) {
      State& state = states_[i];
      const int beyond = level.level() - state.settled;
      if (state.settled < 0 || beyond < 1 || beyond > kBeyond) continue;
      const Patch& patch = patches.of(cell);
      if (patch.shape != Patch::Shape::kSurface || !(patch.ratio < kFlat)) continue;
      if (!(std::abs(patch.normal.dot(surfels_.normals.col(i))) > kParallel)) continue;
      const float size = sizeOf(level.level()), own = surfels_.thicknesses[i];
      state.layers = std::max(state.layers, size * size * patch.variance - own * own);
    }
  }

  std::vector<Settled> settledIn(const CellLevel& level) const {
    std::vector<Settled> settled(level.size());
    for (std::size_t cell = 0; cell < level.size(); ++cell) {
      for (std::uint32_t i = level.begin(cell); i < level.end(cell); ++i) {
        if (!(states_[i].ratio < kFlat)) continue;
        settled[cell].count += 1;
        settled[cell].variance += surfels_.thicknesses[i] * surfels_.thicknesses[i];
      }
    }
    return settled;
  }

  bool isOpen(const CellLevel& level, std::size_t cell) const {
    const auto open = [](const State& state) { return state.open; };
    return std::any_of(states_.begin() + level.begin(cell), states_.begin() + level.end(cell), open);
  }

  static Settled settledAround(const CellNeighbors& neighbors, const std::vector<Settled>& settled) {
    Settled all;
    for (const auto& neighbor : neighbors) {
      all.count += settled[neighbor.cell].count;
      all.variance += settled[neighbor.cell].variance;
    }
    return all;
  }

  static float countAround(const CellLevel& level, const CellNeighbors& neighbors) {
    float count = 0;
    for (const auto& neighbor : neighbors) count += level.moments(neighbor.cell).count;
    return count;
  }

  /// Where the map is thin, what is not flat is structure: it keeps the best patch so far, if it is near enough, and is
  /// not thicker than the map is around.
  void closeThin(const CellLevel& level, std::size_t cell, const Settled& around) {
    const float thickness = std::sqrt(around.variance / around.count);
    for (std::uint32_t i = level.begin(cell); i < level.end(cell); ++i) {
      State& state = states_[i];
      if (!state.open || state.first < 0 || state.line_width >= 0) continue;
      state.open = false;
      surfels_.thicknesses[i] = std::min(thickness, surfels_.thicknesses[i]);
      if (std::abs(surfels_.offsets[i]) <= kDeviations * thickness) continue;
      surfels_.thicknesses[i] = surfels_.offsets[i] = 0;
      surfels_.normals.col(i).setZero();
    }
  }

  /// What the patches of a cell and of those around it tell its open points.
  void takeAll(const CellLevel& level, std::size_t cell, const CellNeighbors& neighbors, CellPatches& patches) {
    const Patch& patch = patches.of(cell);
    if (patch.shape == Patch::Shape::kFew && level.level() < max_level_) return;
    for (std::uint32_t i = level.begin(cell); i < level.end(cell); ++i) {
      State& state = states_[i];
      if (!state.open) continue;
      if (state.first < 0) begin(i, patch, level.level());
      const Eigen::Vector3f at = positionInCell(gridPosition(points_.col(i), grid_), level.level());
      takeSurface(i, patch, at, kOwnShare, level.level());
      if (!(state.ratio < kFlat)) takeFromBeside(i, at, neighbors, patches, level.level());
      state.open = !(state.ratio < kFlat) && level.level() < state.first + kMaxGrowth;
      if (!state.open) state.settled = static_cast<std::int8_t>(level.level());
    }
  }

  /// Near an edge it is the surface of one side, which lies beside the point. The flattest of them.
  void takeFromBeside(std::uint32_t i, const Eigen::Vector3f& at, const CellNeighbors& neighbors, CellPatches& patches,
                      int level) {
    for (const auto& neighbor : neighbors) {
      const Patch& patch = patches.of(neighbor.cell);
      if (patch.ratio < kFlat) takeSurface(i, patch, at - neighbor.offset, kBesideShare, level);
    }
  }

  /// At the first level with enough points, or at the last.
  void begin(std::uint32_t i, const Patch& patch, int level) {
    State& state = states_[i];
    const float cell = sizeOf(level);
    state.first = static_cast<std::int8_t>(level);
    state.density = patch.density * std::ldexp(1.0F, -3 * level);
    state.line_width = patch.shape == Patch::Shape::kLine ? cell * patch.width : -1;
    // What stands alone hides nothing but its place.
    surfels_.radii[i] = patch.shape == Patch::Shape::kFew ? 0 : kBall * cell;
    if (patch.shape != Patch::Shape::kFew) surfels_.thicknesses[i] = kBallScatter * cell * std::sqrt(patch.variance);
  }

  /// The patch, if it is flatter than the best so far and the point is part of it. `at`: the point, as the patch has
  /// it.
  void takeSurface(std::uint32_t i, const Patch& patch, const Eigen::Vector3f& at, float share, int level) {
    State& state = states_[i];
    if (patch.shape != Patch::Shape::kSurface || !(patch.ratio < state.ratio)) return;
    const float cell = sizeOf(level), offset = patch.offset(at), thickness = std::sqrt(patch.variance);
    if (!(std::abs(offset) <= kDeviations * thickness + share)) return;
    if (level > state.first && !isSlab(state, patch, level)) return;
    state.ratio = patch.ratio;
    surfels_.normals.col(i) = patch.normalAt(at).normalized();
    surfels_.offsets[i] = cell * offset;
    surfels_.thicknesses[i] = cell * thickness;
    const float closing = kClosing * patch.spacing;
    surfels_.radii[i] =
        cell * (state.line_width < 0 ? closing : std::max(closing, std::min(kAcrossLines, kSparse * closing)));
  }

  /// Whether a larger neighbourhood than the first is as full of points as that was, or is a surface across lines.
  bool isSlab(const State& state, const Patch& patch, int level) const {
    if (state.line_width >= 0) {
      return std::sqrt(patch.variance) <= kLineWidth * state.line_width / sizeOf(level) + kLineShare;
    }
    return patch.density * std::ldexp(1.0F, -3 * level) >= kFill * state.density;
  }

  float sizeOf(int level) const { return std::ldexp(grid_.cell, level); }  ///< m, of a cell

  const Points& points_;
  const ZOrderGrid& grid_;
  int max_level_;
  std::uint32_t min_count_;
  std::vector<State> states_;
  Surfels surfels_;
};

}  // namespace

Points Surfels::onSurface(PointsRef points) const {
  Points places(3, points.cols());
  for (Index i = 0; i < points.cols(); ++i) places.col(i) = onSurface(i, points.col(i));
  return places;
}

void SurfelParams::check() const {
  requireInRange("num_neighbors", num_neighbors, 4, 100);
}

Surfels estimateSurfels(PointsRef points, Index num_own, const ZOrderGrid& grid, int max_level,
                        const SurfelParams& params) {
  params.check();
  require<std::invalid_argument>(points.allFinite(), "surfels: a point is not finite; drop such points first");
  Surfels surfels = noSurfels(num_own);
  if (num_own == 0) return surfels;
  const Distinct distinct = distinctPoints(points, grid);
  Estimator estimator(distinct, grid, max_level, params);
  const Surfels all = estimator.finish();
  for (Index i = 0; i < num_own; ++i) {
    const auto from = static_cast<Index>(distinct.of_point[static_cast<std::size_t>(i)]);
    surfels.normals.col(i) = all.normals.col(from);
    surfels.radii[i] = all.radii[from];
    surfels.offsets[i] = all.offsets[from];
    surfels.thicknesses[i] = all.thicknesses[from];
  }
  return surfels;
}

Surfels estimateSurfels(PointsRef points, const SurfelParams& params) {
  constexpr int kBits = kZOrderBits - 1;
  require<std::invalid_argument>(points.allFinite(), "surfels: a point is not finite; drop such points first");
  return estimateSurfels(points, points.cols(), gridOf(points, kBits), kBits, params);
}

}  // namespace cloud_colorizer
