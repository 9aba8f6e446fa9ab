// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause

/// From observations to what is no colour: a measured value, or a class.
#pragma once

#include <cstddef>
#include <vector>

#include "cloud_colorizer/camera/view.hpp"
#include "cloud_colorizer/cloud/cloud.hpp"
#include "cloud_colorizer/color/point_colors.hpp"

namespace cloud_colorizer {

/// radiometric: `name` FLOAT32, `name`_views UINT16, its number of views; labels and logits: `name` UINT16, the number
/// of the class, and `name`_confidence FLOAT32, 0 to 1. Where no view tells, all are 0.
std::vector<Field> fieldsOf(const Quantity& quantity);

/// Points that are fused at a time: the scores of many classes take much memory.
std::size_t pointsAtATime(const Quantity& quantity, int channels);

/// A row for each field of the quantity, a column for each point.
///
/// radiometric: as colours are fused by `method`, on a scale where 255 is the range of all but the least and the
/// greatest hundredth of the values, so that no unit of the numbers matters.
/// labels: the class with the greatest sum of weights (ties: the smallest number); confidence is its share.
/// logits: with l_i the logarithm of the softmax of view i, the class k with the greatest S_k = sum_i w_i l_i,k, as if
/// the views were independent, where w_i is 1 for the best of them; confidence is exp(S_k) / sum_j exp(S_j).
Values fuseQuantity(PointsRef points, Observations observations, const ZOrderGrid& grid, ImageKind kind, Method method,
                    const GraphParams& graph, const SystemParams& system);

}  // namespace cloud_colorizer
