// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause
#include "cloud_colorizer/surface/zorder.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numeric>

#include "cloud_colorizer/base/check.hpp"

namespace cloud_colorizer {
namespace {

constexpr std::uint64_t kAxisMax = (std::uint64_t{1} << kZOrderBits) - 1;

/// Moves bit i to bit 3 i.
constexpr std::uint64_t spreadBits(std::uint64_t x) {
  x = (x | x << 32) & 0x001f00000000ffff;
  x = (x | x << 16) & 0x001f0000ff0000ff;
  x = (x | x << 8) & 0x100f00f00f00f00f;
  x = (x | x << 4) & 0x10c30c30c30c30c3;
  x = (x | x << 2) & 0x1249249249249249;
  return x;
}

std::uint64_t gridCoordinate(PointsRef points, Eigen::Index p, int axis, const ZOrderGrid& grid) {
  // In double: the difference of two floats is exact enough that a chunk and the whole map agree.
  const double cells = std::floor((static_cast<double>(points(axis, p)) - grid.origin(axis)) / grid.cell);
  require<std::out_of_range>(cells >= 0 && cells <= static_cast<double>(kAxisMax), "point ", p, ": ", "xyz"[axis],
                             " = ", points(axis, p), " m lies outside of the Z-order grid from ", grid.origin(axis),
                             " m with ", kAxisMax + 1, " cells of ", grid.cell, " m; use a larger cell");
  return static_cast<std::uint64_t>(cells);
}

}  // namespace

ZOrderGrid gridOf(PointsRef points, int bits) {
  requireInRange("bits", bits, 1, kZOrderBits - 1);  // one bit to spare for rounding
  ZOrderGrid grid;
  if (points.cols() == 0) return grid;
  grid.origin = points.rowwise().minCoeff();
  const float extent = (points.rowwise().maxCoeff() - grid.origin).maxCoeff();
  const float cell = extent / static_cast<float>((1 << bits) - 1);
  if (extent > 0) grid.cell = std::max(std::numeric_limits<float>::min(), cell);  // that of a tiny extent is 0
  return grid;
}

std::vector<std::uint64_t> zorderKeys(PointsRef points, const ZOrderGrid& grid) {
  require<std::invalid_argument>(std::isfinite(grid.cell) && grid.cell > 0 && grid.origin.allFinite(),
                                 "Z-order grid: cell = ", grid.cell,
                                 " m must be greater than 0, and the origin finite");
  std::vector<std::uint64_t> keys(static_cast<std::size_t>(points.cols()));
  for (Eigen::Index p = 0; p < points.cols(); ++p) {
    std::uint64_t key = 0;
    for (int axis = 0; axis < 3; ++axis) key |= spreadBits(gridCoordinate(points, p, axis, grid)) << axis;
    keys[static_cast<std::size_t>(p)] = key;
  }
  return keys;
}

std::uint64_t zorderMask(int pass) {
  requireInRange("passes", pass, 0, kMaxPasses - 1);
  return pass == 0 ? 0 : spreadBits(kAxisMax) << (pass - 1);
}

std::vector<std::uint64_t> shiftedKeys(const std::vector<std::uint64_t>& keys, int pass) {
  requireInRange("passes", pass, 0, kMaxPasses - 1);
  if (pass == 0) return keys;
  const std::uint64_t cells =
      (std::uint64_t{1} << (kZOrderBits - 1)) / (kMaxPasses + 1) * static_cast<std::uint64_t>(pass);
  std::vector<std::uint64_t> shifted(keys.size(), 0);
  for (int axis = 0; axis < 3; ++axis) {
    const std::uint64_t bits = spreadBits(kAxisMax) << axis, shift = spreadBits(cells) << axis;
    // With ones in between, a carry reaches the axis' next bit.
    for (std::size_t i = 0; i < keys.size(); ++i) shifted[i] |= ((keys[i] | ~bits) + shift) & bits;
  }
  return shifted;
}

std::vector<std::uint32_t> zorderSort(const std::vector<std::uint64_t>& keys, std::uint64_t mask) {
  require<std::out_of_range>(keys.size() <= std::numeric_limits<std::uint32_t>::max(), keys.size(),
                             " points exceed the 32-bit indices; use smaller chunks");
  const auto before = [mask](std::uint64_t a, std::uint64_t b) { return (a ^ mask) < (b ^ mask); };
  if (std::is_sorted(keys.begin(), keys.end(), before)) {  // a chunk's points are, for the first pass
    std::vector<std::uint32_t> order(keys.size());
    std::iota(order.begin(), order.end(), 0U);
    return order;
  }
  // An item is the 32 bits from the highest one in which keys differ, and the index. Few points agree in those.
  std::uint64_t differing = 0;
  for (const std::uint64_t key : keys) differing |= key ^ keys[0];
  const int dropped = std::max(0, 32 - __builtin_clzll(differing));
  std::vector<std::uint64_t> items(keys.size()), sorted(keys.size());
  for (std::size_t i = 0; i < keys.size(); ++i) items[i] = ((keys[i] ^ mask) >> dropped << 32) | i;
  for (int shift = 32; shift < 64; shift += 8) {
    if ((differing >> dropped << 32 >> shift & 0xff) == 0) continue;
    std::array<std::uint32_t, 257> starts{};
    for (const std::uint64_t item : items) ++starts[(item >> shift & 0xff) + 1];
    for (std::size_t b = 1; b < starts.size(); ++b) starts[b] += starts[b - 1];
    for (const std::uint64_t item : items) sorted[starts[item >> shift & 0xff]++] = item;
    items.swap(sorted);
  }
  std::vector<std::uint32_t> order(items.begin(), items.end());  // the lower halves
  const auto before_or_first = [&](std::uint32_t a, std::uint32_t b) {
    return keys[a] == keys[b] ? a < b : before(keys[a], keys[b]);
  };
  for (std::size_t begin = 0, end = 0; dropped > 0 && begin < items.size(); begin = end) {
    for (end = begin + 1; end < items.size() && items[end] >> 32 == items[begin] >> 32;) ++end;
    if (end - begin > 1) std::sort(order.begin() + begin, order.begin() + end, before_or_first);
  }
  return order;
}

}  // namespace cloud_colorizer
