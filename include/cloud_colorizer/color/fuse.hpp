// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause

/// Fusing: one value a point from its views alone. The comparison methods, and the data term of the solve.
#pragma once

#include "cloud_colorizer/base/types.hpp"
#include "cloud_colorizer/visibility/observe.hpp"

namespace cloud_colorizer {

/// One column a point; a point without observations has zeros.
struct Fused {
  Values values;           ///< m x n
  Eigen::VectorXi count;   ///< n, number of views
  Eigen::VectorXf stddev;  ///< n, standard deviation over the views, mean over the channels; 0 for one view
  /// Final weight of every observation, 0 to 1, 0 for an outlier. By fuseRobust only, otherwise empty.
  Eigen::VectorXf observation_weights;
};

/// Throws std::invalid_argument unless the columns of `observations` fit together and all values are finite.
/// Every function below calls it.
void checkObservations(const Observations& observations);

// These three do not look at Observations::weights, as in the paper.
Fused fuseClosest(const Observations& observations);  ///< value of the nearest view
Fused fuseMean(const Observations& observations);     ///< plain mean, v-bar of eq. (2)
Fused fuseMedian(const Observations& observations);   ///< median by channel

/// Weighted mean with Tukey weights about the weighted median, so that a passer-by in one view leaves no ghost.
/// An observation's residual is the root mean square over its channels; the scale is 1.4826 times the median residual,
/// but at least `min_scale` (> 0, in the units of the values). Observations::weights multiply in; stddev is weighted.
/// One or two views, where nobody can say who is wrong: the weighted mean.
Fused fuseRobust(const Observations& observations, float min_scale);

}  // namespace cloud_colorizer
