// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause

/// What is expected of the corrections before an image is looked at, and how each view moves.
#pragma once

#include <vector>

#include "alignment/motion.hpp"
#include "cloud_colorizer/alignment/align.hpp"

namespace cloud_colorizer::alignment {

/// s between views of a camera that still follow each other on one trajectory; less than the 1 s that a model of
/// photographs is given.
constexpr double kMaxStampGap = 0.95;

/// Standard deviations of what is expected (see AlignmentParams), and how each view moves.
struct PosePriors {
  std::vector<Twist> view_sigmas, camera_sigmas, velocities;
  std::vector<double> time_sigmas;  ///< s, by camera
  /// By view: the one before it of the same camera in time, its own number where there is none.
  std::vector<std::size_t> previous;
  /// By camera, of the difference to the previous view's correction: infinite where nothing is known; empty: for none.
  std::vector<Twist> step_sigmas;
};
/// `depths`: median depth of the points of every view, m. A camera's centre is expected to be off by as many pixels as
/// its rotation.
PosePriors makePriors(const AlignmentInput& input, const AlignmentParams& params, const std::vector<double>& depths);
/// Learns step_sigmas from the corrections so far: where those of most views follow each other smoothly, as the drift
/// of a trajectory does, one that jumps is an error of its images. Noise of every pose by itself leaves them loose.
void learnSteps(const std::vector<View>& views, const PoseState& state, PosePriors& priors);
/// Motion of every view a second in its own frame, from its neighbours in time of the same camera; 0 without.
std::vector<Twist> viewVelocities(const std::vector<View>& views);

}  // namespace cloud_colorizer::alignment
