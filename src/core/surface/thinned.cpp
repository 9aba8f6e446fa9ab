// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause
#include "surface/thinned.hpp"

#include <cmath>

namespace cloud_colorizer {
namespace {

using Eigen::Index;

constexpr int kCoarsest = kZOrderBits - 4, kFinest = kCoarsest - 10;  // of the grid of a tile: some cells are in it

}  // namespace

std::vector<ThinnedSurface> thinSurface(const Surface& surface, const ZOrderGrid& grid) {
  std::vector<ThinnedSurface> thinned;
  const std::vector<std::uint64_t> keys = zorderKeys(surface.points, grid);
  const std::vector<std::uint32_t> order = zorderSort(keys, zorderMask(0));
  std::vector<Index> before(order.begin(), order.end());
  std::size_t num_last = before.size();
  for (int level = kFinest; level <= kCoarsest && !before.empty(); ++level) {
    std::vector<Index> kept;
    std::uint64_t cube = 0;
    bool has_standing = false, has_moving = false;
    for (const Index i : before) {
      const std::uint64_t key = keys[static_cast<std::size_t>(i)] >> (3 * level);
      if (kept.empty() || key != cube) has_standing = has_moving = false;
      cube = key;
      bool& has = surface.surfels.radii[i] < 0 ? has_moving : has_standing;
      if (!has) kept.push_back(i);
      has = true;
    }
    if (2 * kept.size() <= num_last) {
      thinned.push_back({std::ldexp(grid.cell, level), gatherSurface(surface, kept)});
      num_last = kept.size();
    }
    before = std::move(kept);
  }
  return thinned;
}

}  // namespace cloud_colorizer
