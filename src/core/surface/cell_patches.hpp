// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause

/// The patches of the cells of a level.
#pragma once

#include <vector>

#include "surface/patch.hpp"

namespace cloud_colorizer {

/// Of a cell and those that touch it. Each is made when it is first asked for.
class CellPatches {
 public:
  /// A patch needs `min_count` points.
  CellPatches(const CellLevel& level, float min_count)
      : level_(level), neighbors_(level), min_count_(min_count), patches_(level.size()), made_(level.size(), 0) {}

  const Patch& of(std::size_t cell) {
    if (made_[cell] == 0) {
      made_[cell] = 1;
      make(cell, patches_[cell]);
    }
    return patches_[cell];
  }

 private:
  void make(std::size_t cell, Patch& patch) {
    neighbors_.moveTo(cell);
    Moments moments;
    for (const auto& neighbor : neighbors_) moments.add(level_.moments(neighbor.cell), neighbor.offset);
    if (moments.count < min_count_) return;
    patch = fitPlane(moments);
    if (patch.shape == Patch::Shape::kSurface) bendPatch(level_, neighbors_, patch);
  }

  const CellLevel& level_;
  CellNeighbors neighbors_;
  float min_count_;
  std::vector<Patch> patches_;
  std::vector<char> made_;
};

}  // namespace cloud_colorizer
