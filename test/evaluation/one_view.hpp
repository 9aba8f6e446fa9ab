// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "cloud_colorizer/visibility/observe.hpp"

namespace cloud_colorizer {

/// Every point is seen once, by the same view, with the value 120.
inline Observations seenByOneView(std::uint32_t num_points) {
  Observations observations;
  for (std::uint32_t p = 0; p <= num_points; ++p) observations.offsets.push_back(p);
  observations.views.assign(num_points, 0);
  observations.distances.assign(num_points, 1);
  observations.weights.assign(num_points, 1);
  observations.values = Values::Constant(3, num_points, 120);
  return observations;
}

}  // namespace cloud_colorizer
