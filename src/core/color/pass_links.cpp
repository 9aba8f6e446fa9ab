// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause
#include "color/pass_links.hpp"

#include <algorithm>
#include <array>

#include "cloud_colorizer/surface/zorder.hpp"

namespace cloud_colorizer {
namespace {

/// A block of the grid's binary tree: the points at which each pass enters and leaves it.
struct TreeBlock {
  std::array<std::uint32_t, kMaxPasses> first, last;
  int split = 0;  // highest bit in which the keys of this block and of the next one on the stack differ

  explicit TreeBlock(std::uint32_t point) {
    first.fill(point);
    last.fill(point);
  }
};

/// Highest bit in which two keys differ, -1 if none.
int splitBit(std::uint64_t a, std::uint64_t b) {
  return a == b ? -1 : 63 - __builtin_clzll(a ^ b);
}

class BlockLinker {
 public:
  explicit BlockLinker(int passes) : passes_(passes) {
    for (int pass = 0; pass < passes; ++pass) masks_[pass] = zorderMask(pass);
  }

  /// Joins `low` and `high`, that differ in bit low.split, and links them once in every pass.
  void join(TreeBlock& low, const TreeBlock& high, std::vector<Link>& links) const {
    const std::size_t begin = links.size();
    for (int pass = 0; pass < passes_; ++pass) {
      // A pass that mirrors this bit's axis visits the high half before the low one; equal keys keep their order.
      const bool mirrored = low.split >= 0 && (masks_[pass] >> low.split & 1) != 0;
      const std::uint32_t a = mirrored ? high.last[pass] : low.last[pass];
      const std::uint32_t b = mirrored ? low.first[pass] : high.first[pass];
      const Link link(std::min(a, b), std::max(a, b));
      if (std::find(links.begin() + begin, links.end(), link) == links.end()) links.push_back(link);
      (mirrored ? low.first : low.last)[pass] = (mirrored ? high.first : high.last)[pass];
    }
    low.split = high.split;
  }

 private:
  int passes_;
  std::array<std::uint64_t, kMaxPasses> masks_{};
};

}  // namespace

std::vector<Link> ownGridLinks(const std::vector<std::uint64_t>& keys, int passes) {
  std::vector<Link> links;
  links.reserve(keys.size() * static_cast<std::size_t>(passes));
  for (int pass = 0; pass < passes; ++pass) {
    const std::vector<std::uint32_t> order = zorderSort(shiftedKeys(keys, pass), zorderMask(pass));
    for (std::size_t i = 1; i < order.size(); ++i) links.push_back(std::minmax(order[i - 1], order[i]));
  }
  return links;
}

std::vector<Link> sharedGridLinks(const std::vector<std::uint64_t>& keys, int passes) {
  const std::vector<std::uint32_t> order = zorderSort(keys, 0);
  const BlockLinker linker(passes);
  std::vector<Link> links;
  links.reserve(keys.size() * (passes == 1 ? 1 : 2));
  std::vector<TreeBlock> stack;  // splits descend from the bottom, so it holds 64 blocks at most
  for (std::size_t i = 0; i < order.size(); ++i) {
    stack.emplace_back(order[i]);
    stack.back().split = i + 1 < order.size() ? splitBit(keys[order[i]], keys[order[i + 1]]) : 64;
    while (stack.size() > 1 && stack[stack.size() - 2].split <= stack.back().split) {
      linker.join(stack[stack.size() - 2], stack.back(), links);
      stack.pop_back();
    }
  }
  return links;
}

std::vector<int> orderByLastLink(std::size_t num_points, const std::vector<Link>& links) {
  std::vector<int> order(num_points);  // filled from the back, with every point that is new
  std::vector<std::uint8_t> placed(num_points, 0);
  std::size_t end = num_points;
  const auto place = [&](std::uint32_t point) {
    if (placed[point]) return;
    placed[point] = 1;
    order[--end] = static_cast<int>(point);
  };
  for (auto link = links.rbegin(); link != links.rend(); ++link) {
    place(link->first);
    place(link->second);
  }
  for (std::uint32_t point = 0; point < placed.size(); ++point) place(point);  // one point alone has no link
  return order;
}

}  // namespace cloud_colorizer
