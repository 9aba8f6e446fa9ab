// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause

/// Vignetting: how much darker a camera's images are towards their corners.
#pragma once

#include <vector>

#include "alignment/tracks.hpp"
#include "base/parallel.hpp"

namespace cloud_colorizer::alignment {

/// Coefficients (see Exposure::vignetting) of every camera.
/// `values` [grey levels, > 0] and `weights` by observation; weight 0 has no vote. Gains of views and the points' own
/// brightness are free: with columns demeaned by view and by point (the Frisch-Waugh-Lovell theorem) what remains is a
/// regression of log brightness on r^2 and r^4.
std::vector<Eigen::Array2f> estimateVignetting(const AlignmentInput& input, const Tracks& tracks,
                                               const PoseState& state, const std::vector<float>& values,
                                               const std::vector<float>& weights, const Workers& workers);

}  // namespace cloud_colorizer::alignment
