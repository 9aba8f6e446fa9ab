// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause

/// Poses: one joint Gauss-Newton problem over the corrections of all views, cameras and clocks.
#pragma once

#include <vector>

#include "alignment/blurred_images.hpp"
#include "alignment/priors.hpp"
#include "alignment/tracks.hpp"
#include "base/parallel.hpp"

namespace cloud_colorizer::alignment {

/// What the poses are estimated from, at one blur.
struct PoseData {
  const AlignmentInput* input;
  const Tracks* tracks;
  const BlurredImages* images;
  const Eigen::VectorXd* log_gains;
  const Workers* workers;
  const Eigen::VectorXf* ranks = nullptr;  ///< of the points' intensities; null: no tie to them
};

struct PoseRounds {
  double residual_first = 0, residual_last = 0;  ///< grey levels, median
  double explained = 0;              ///< share of the grey level's local variance that the intensity explains
  std::vector<double> time_stddevs;  ///< s, by camera
  int accepted = 0;
};
/// Largest part of a step of the views' corrections, in sigmas of their own camera's prior.
double largestStep(const Eigen::VectorXd& step, const std::vector<View>& views, const PosePriors& priors);
/// Some Levenberg-Marquardt steps.
PoseRounds refinePoses(const PoseData& data, const PosePriors& priors, PoseState& state);

/// Tries time offsets that all cameras share, within +-4 of their priors' sigma, and returns the best, s; 0 when
/// nothing moves. The capture range of Gauss-Newton is some pixels; a clock can be off by much more.
/// `trials` takes what was tried.
double searchTimeOffset(const PoseData& data, const PosePriors& priors, const PoseState& state,
                        std::vector<ClockTrial>& trials);

/// Grey level of every observation, without gain.
SightValues greyValues(const PoseData& data, const PoseState& state);

}  // namespace cloud_colorizer::alignment
