// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause

/// The course of the alignment: who sees what, poses from coarse to fine, what is refused, exposures, figures.
#pragma once

#include <string>
#include <vector>

#include "alignment/proof.hpp"

namespace cloud_colorizer::alignment {

constexpr double kFinestBlur = 0.7;  ///< px of the small images

/// One sentence: what held-back points say of a correction.
std::string describe(const Evidence& evidence);

/// Why a view keeps the pose it came with; empty: it does not. `sigmas`: its correction in sigmas of its prior.
std::string refusal(double sigmas, const Evidence& evidence);

/// Everything that align() works on. Its input's points lie on their surface; `thickness`: of the slab that they made
/// before, m.
class Aligner {
 public:
  Aligner(const AlignmentInput& input, double thickness, const AlignmentParams& params, const Callbacks& callbacks);

  AlignmentResult run();

 private:
  // aligner.cpp: the stages, in their order
  bool hasDepth8Bit();
  void look(bool all, std::size_t points);
  bool hasOverlap();
  Tracks tracksOf(const std::vector<std::vector<Sight>>& sights, std::size_t points, bool with_held_back) const;
  std::vector<double> medianDepths() const;
  double blockSide(const std::vector<double>& depths) const;
  void refine();
  void updateGains(PoseData data);
  std::size_t fewPoints() const;
  double startBlur() const;
  std::vector<double> levels() const;
  PoseData dataOf(const BlurredImages& images) const;
  void show(std::size_t done, std::size_t total) const;
  void log(const std::string& text) const;

  // outcome.cpp: what is kept of the corrections, and what is told of them
  void shareCommon(const Tracks& tracks);
  void keepProven(const BlurredImages& images);
  void keepViews(const PoseData& data);
  Showing keepByCamera(const PoseData& data, const std::string& what, const PoseState& without, const Showing& before);
  void judge(const PoseData& data);
  void report();
  std::uint32_t cameraOf(std::size_t view) const { return input_.views[view].camera; }
  Twist expected(std::size_t view) const;
  PoseState uncorrected() const;
  double pixelsOf(std::size_t view, const PoseState& from, const PoseState& to) const;

  // diagnosis.cpp: what a correction that is kept says about the recording
  void findClocks();
  void suspectClocks(const PoseData& data, const PoseState& clocks, const PoseState& all);
  void suspectCalibration(const PoseData& data);
  bool explains(const PoseData& data, const Showing (&shown)[3], std::uint32_t camera, double share) const;
  double medianShift(std::uint32_t camera, const PoseState& from, const PoseState& to) const;
  void warnAboutCamera(std::uint32_t c);

  const AlignmentInput& input_;
  const AlignmentParams& params_;
  Workers workers_;
  std::vector<PointRun> runs_;
  SmallImages images_;
  std::size_t max_points_ = 0;                             // of a view
  std::vector<std::vector<Sight>> sights_, first_sights_;  // by view: at its present pose, and at the one it came with
  Blocks blocks_;
  Tracks tracks_;  // of what is not held back
  PosePriors priors_;
  PoseState state_, seen_at_;
  Eigen::VectorXd log_gains_;
  Eigen::VectorXf ranks_;  // of the intensities; empty: no tie to them
  AlignmentResult result_;
};

}  // namespace cloud_colorizer::alignment
