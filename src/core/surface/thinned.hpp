// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause

/// A dense surface by fewer points: what a view from afar needs of it.
#pragma once

#include <vector>

#include "cloud_colorizer/surface/zorder.hpp"
#include "surface/surface.hpp"

namespace cloud_colorizer {

struct ThinnedSurface {
  float cell = 0;  ///< m; of points in a cube of this side only the first is left
  Surface surface;
};

/// Fine to coarse: in each cube of 2^k grid cells the first point in Z-order of what stands, and the first of what
/// moved (radius < 0). Only surfaces with at most half of the points of the one before.
std::vector<ThinnedSurface> thinSurface(const Surface& surface, const ZOrderGrid& grid);

}  // namespace cloud_colorizer
