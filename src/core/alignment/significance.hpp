// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause

/// Significance: a correction that is no larger than its own uncertainty is worse than none.
///
/// The uncertainty is measured, because a model of the noise knows nothing of shading and of wrong surfaces. The map is
/// cut into blocks. Each block b pulls at the corrections with the gradient g_b of its own observations, and how much
/// the pulls differ gives the covariance H^-1 (sum_b g_b g_b') H^-1: the sandwich estimator with clusters.
/// All corrections of one kind are then multiplied by one factor, max(0, 1 - (2 u^2 / s^2)^2): s is their size and u
/// their uncertainty, both a root mean square in pixels of the image. u is never less than a constant, for errors that
/// all blocks share. The idea is James' and Stein's; the factor is nearer to "all or nothing" than theirs, and 1 for
/// large corrections.
#pragma once

#include <vector>

#include "alignment/refine_poses.hpp"

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
/// Of one member of a group: the larger of the group's factor and its own, the latter with 1.5 times the uncertainty.
double shrinkFactor(double group_size, double own_size, double uncertainty);

/// Shrinks what is in `state`, where refinePoses() has converged with the same data and priors.
PoseShrinkage shrinkPoses(const PoseData& data, const PosePriors& priors, PoseState& state);

/// Groups for the points' blocks, a number for each point in [0, kPointGroups).
PointGroups groupPoints(const AlignmentInput& input, double block);

}  // namespace cloud_colorizer::alignment
