// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause

/// From observations to one value a point: the comparison methods, and eq. (1)-(5) of the paper.
#pragma once

#include "cloud_colorizer/base/types.hpp"
#include "cloud_colorizer/map/params.hpp"
#include "cloud_colorizer/surface/zorder.hpp"
#include "cloud_colorizer/visibility/observe.hpp"

namespace cloud_colorizer {

/// One column a point; zeros where no view saw it.
struct PointColors {
  Values values;           ///< m x n
  Eigen::VectorXi count;   ///< n, number of views
  Eigen::VectorXf stddev;  ///< n, over the views
};

/// Colours by params.colorize.method. Points that no view sees take no part in the graph.
/// `paper` is the formulation as published: plain means, all views alike, no weight on points that are no anchors.
PointColors colorPoints(PointsRef points, Observations observations, const ZOrderGrid& grid, const Params& params);

}  // namespace cloud_colorizer
