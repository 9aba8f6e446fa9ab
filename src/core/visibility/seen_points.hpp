// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause

/// Points that no view sees take no part in a graph.
#pragma once

#include <vector>

#include "cloud_colorizer/visibility/observe.hpp"

namespace cloud_colorizer {

/// The points that some view sees; the rows of the others, which are empty, are taken out.
inline std::vector<Eigen::Index> keepSeen(Observations& observations) {
  std::vector<Eigen::Index> seen;
  std::vector<std::uint32_t> offsets(1, 0);
  for (std::size_t p = 0; p < observations.numPoints(); ++p) {
    if (observations.offsets[p + 1] == observations.offsets[p]) continue;
    seen.push_back(static_cast<Eigen::Index>(p));
    offsets.push_back(observations.offsets[p + 1]);
  }
  observations.offsets = std::move(offsets);
  return seen;
}

}  // namespace cloud_colorizer
