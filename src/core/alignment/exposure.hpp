// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause

/// Exposure and sharpness of the views against each other, at given poses.
#pragma once

#include <vector>

#include "alignment/motion.hpp"
#include "alignment/proof.hpp"
#include "alignment/tracks.hpp"
#include "base/parallel.hpp"

namespace cloud_colorizer::alignment {

/// Gain by view and channel, and, if wanted, the vignetting of its camera, where held-back points prove them; where
/// poses are uncertain, `sigma` [px of the small images] should blur the uncertainty away.
std::vector<Exposure> estimateExposures(const AlignmentInput& input, const Tracks& tracks, const Blocks& blocks,
                                        const PoseState& state, double sigma, bool with_vignetting,
                                        const Workers& workers);

/// Relative sharpness of every view, 0.1 to 1: how strong its gradients are (per metre on the surface) beside those
/// of other views of the same points, after the gains; 1 for the median view and better ones, its square as a weight.
std::vector<float> sharpnessWeights(const AlignmentInput& input, const Tracks& tracks, const PoseState& state,
                                    const std::vector<Exposure>& exposures, const SmallImages& small,
                                    const Workers& workers);

}  // namespace cloud_colorizer::alignment
