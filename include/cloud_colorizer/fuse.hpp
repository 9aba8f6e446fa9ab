// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause

/// Fusing: one value a point from its views alone. The comparison methods, and the data term of the solve.
#pragma once

#include "cloud_colorizer/observe.hpp"
#include "cloud_colorizer/types.hpp"

namespace cloud_colorizer {

/// One column a point; a point without observations has zeros.
struct Fused {
  Values values;           ///< m x n
  Eigen::VectorXi count;   ///< n, number of views
  Eigen::VectorXf stddev;  ///< n, standard deviation over the views, mean over the channels; 0 for one view
};

Fused fuseClosest(const Observations& observations);  ///< value of the nearest view
Fused fuseMean(const Observations& observations);     ///< plain mean, v-bar of eq. (2)
Fused fuseMedian(const Observations& observations);   ///< median by channel
/// Weighted mean with Tukey weights about the median, scale from the median absolute deviation (at least `min_scale`
/// of the value scale), so that a passer-by in one view leaves no ghost.
Fused fuseRobust(const Observations& observations, float min_scale);

}  // namespace cloud_colorizer
