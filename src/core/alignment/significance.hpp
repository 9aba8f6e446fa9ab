// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause

/// Significance: a correction that is no larger than its own uncertainty is worse than none.
///
/// The uncertainty is taken from the data and not from the model, which knows nothing of shading, wrong surfaces and
/// what else the images get wrong together: the map is cut into blocks, and the scatter of the blocks' pulls g_b on
/// the corrections gives their covariance, H^-1 (sum_b g_b g_b') H^-1 (the sandwich estimator with clusters). From it
/// each group of corrections is shrunk, in the way of James and Stein but firmer, by max(0, 1 - (2 u^2 / s^2)^2), with
/// the group's mean square s^2 and that of its uncertainty u^2, both as shifts in the image; u has a floor for what the
/// whole map gets wrong together. Large corrections stay as they are.
#pragma once

#include <vector>

#include "alignment/poses.hpp"

namespace cloud_colorizer::alignment {

/// What was left of a group's corrections.
struct Shrinkage {
  double pixels = 0;       ///< root mean square shift before
  double uncertainty = 0;  ///< px, root mean square
  double factor = 1;       ///< 0 to 1: what they were multiplied by
};

struct PoseShrinkage {
  std::vector<Shrinkage> cameras, views;  ///< both one a camera; `views`: of all its views against it
};

/// Factor of a group; `uncertainty` and `size` (root mean square) in the same unit.
double shrinkFactor(double size, double uncertainty);
/// Of a member of a group: where it stands out (at a bound half as high again), its own size counts.
double shrinkFactor(double group_size, double own_size, double uncertainty);

/// Shrinks what is in `state`, where refinePoses() has converged with the same data and priors.
PoseShrinkage shrinkPoses(const PoseData& data, const PosePriors& priors, int num_threads, PoseState& state);

/// Groups for the points' blocks, a number for each point in [0, kPointGroups).
PointGroups groupPoints(const AlignmentInput& input, double block);

}  // namespace cloud_colorizer::alignment
