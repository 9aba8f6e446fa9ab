// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause

/// From observations to one value a point: the comparison methods, and eq. (1)-(5) of the paper.
#pragma once

#include "cloud_colorizer/base/types.hpp"
#include "cloud_colorizer/color/fuse.hpp"
#include "cloud_colorizer/color/graph.hpp"
#include "cloud_colorizer/color/system.hpp"
#include "cloud_colorizer/surface/zorder.hpp"
#include "cloud_colorizer/visibility/observe.hpp"

namespace cloud_colorizer {

enum class Method { kDefault, kPaper, kMean, kMedian, kClosest };

/// Whether what changes with the direction of the view is taken out of the colours: not at all, or as spherical
/// harmonics of degree 1 or 2 of the mirrored direction, and the sheen of one light.
enum class Appearance { kNone, kSh1, kSh2 };

/// The fused values, for kDefault and kPaper solved for on the graph, in which points that no view sees take no part.
/// kPaper is the formulation as published: plain means, all views alike, no weight on points that are no anchors.
Fused colorPoints(PointsRef points, Observations observations, const ZOrderGrid& grid, Method method,
                  const GraphParams& graph, SystemParams system);

}  // namespace cloud_colorizer
