// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause

/// Poses: one joint Gauss-Newton problem over the corrections of all views, cameras and clocks.
#pragma once

#include <Eigen/Geometry>
#include <vector>

#include "alignment/blurred_images.hpp"
#include "alignment/tracks.hpp"

namespace cloud_colorizer::alignment {

/// s between views of a camera that still follow each other on one trajectory; less than the 1 s that a model of
/// photographs is given.
constexpr double kMaxStampGap = 0.95;

/// A small motion in a camera's frame: rotation [rad], then translation [m].
using Twist = Eigen::Matrix<double, 6, 1>;

/// p -> R p + t.
Eigen::Isometry3d motion(const Twist& twist);
/// The inverse of motion().
Twist twistOf(const Eigen::Isometry3d& motion);

/// Corrections: the camera's frame sees motion(views[v]) * (what it saw before). A view's correction is expected at
/// cameras[c] + time_offsets[c] * velocity of v.
struct PoseState {
  std::vector<Twist> views, cameras;
  std::vector<double> time_offsets;  ///< s
};
Eigen::Isometry3d correctedPose(const View& view, const Twist& correction);

/// Standard deviations of what is expected (see AlignmentParams), and how each view moves.
struct PosePriors {
  std::vector<Twist> view_sigmas, camera_sigmas, velocities;
  std::vector<double> time_sigmas;  ///< s, by camera
  /// By view: the one before it of the same camera in time, its own number where there is none.
  std::vector<std::size_t> previous;
  std::vector<Twist> step_sigmas;  ///< by camera, of the difference to the previous view's correction; empty: any
};
/// `depths`: median depth of the points of every view, m.
PosePriors makePriors(const AlignmentInput& input, const AlignmentParams& params, const std::vector<double>& depths);
/// Learns step_sigmas from the corrections so far: where those of most views follow each other smoothly, as the drift
/// of a trajectory does, one that jumps is an error of its images. Noise of every pose by itself leaves them loose.
void learnSteps(const std::vector<View>& views, const PoseState& state, PosePriors& priors);
/// Motion of every view a second in its own frame, from its neighbours in time of the same camera; 0 without.
std::vector<Twist> viewVelocities(const std::vector<View>& views);

/// What the poses are estimated from, at one blur.
struct PoseData {
  const AlignmentInput* input;
  const Tracks* tracks;
  const BlurredImages* images;
  const Eigen::VectorXd* log_gains;
  double sigma;                            ///< px, of the blur
  const Eigen::VectorXf* ranks = nullptr;  ///< of the points' intensities; null: no tie to them
};

struct PoseRounds {
  double residual_first = 0, residual_last = 0;  ///< grey levels, median
  double explained = 0;              ///< share of the grey level's local variance that the intensity explains
  std::vector<double> time_stddevs;  ///< s, by camera
  int accepted = 0;
};
/// Up to `rounds` Levenberg-Marquardt steps.
PoseRounds refinePoses(const PoseData& data, const PosePriors& priors, int rounds, int num_threads, PoseState& state);

/// Cost of a state, for comparisons between states that are far apart. `like`: the result for the state to compare
/// with, or a default one.
struct StateCost {
  double cost = 0;  ///< per unit of weight, without priors; lower is better
  float scale = 0;  ///< grey levels, of the robust weights
};
StateCost stateCost(const PoseData& data, const PoseState& state, const StateCost& like, int num_threads);

/// Tries time offsets that all cameras share, within +-4 of their priors' sigma, and returns the best, s; 0 when
/// nothing moves. The capture range of Gauss-Newton is some pixels; a clock can be off by much more.
double searchTimeOffset(const PoseData& data, const PosePriors& priors, const PoseState& state, int num_threads);

/// Grey level of every observation, without gain; weight 0 where there is none.
struct GreyValues {
  std::vector<float> values, weights;
};
GreyValues greyValues(const PoseData& data, const PoseState& state, int num_threads);

}  // namespace cloud_colorizer::alignment
