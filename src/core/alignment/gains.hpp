// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause

/// Gains: one factor a view that makes the views of the same points equally bright.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "alignment/blurred_images.hpp"
#include "alignment/tracks.hpp"
#include "base/parallel.hpp"

namespace cloud_colorizer::alignment {

/// Gains of brightness stay within [1 / kMaxGain, kMaxGain]: a view that needs more saw something else.
constexpr double kMaxGain = 5;

/// log gain x_v of every view: minimises sum rho(v_k (log v_k + x_v(k) - m_p(k))) over x and the points' m, with
/// robust weights, so in grey levels. `values` [grey levels, > 0] and `weights` by observation; weight 0 has no vote.
/// Gauge: the sum of the values of all voting observations stays. A view that shares no point keeps 0. Clamped to
/// +-log(max_gain).
Eigen::VectorXd estimateLogGains(const Tracks& tracks, const std::vector<float>& values,
                                 const std::vector<float>& weights, double max_gain, const Workers& workers);

/// Median of the values of every point among observations of positive weight; 0 without.
std::vector<float> pointMedians(const Tracks& tracks, const std::vector<float>& values,
                                const std::vector<float>& weights);

}  // namespace cloud_colorizer::alignment
