// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause

/// The course of the alignment: who sees what, poses from coarse to fine, what is refused, exposures, figures.
#pragma once

#include <string>
#include <vector>

#include "alignment/refine_poses.hpp"

namespace cloud_colorizer::alignment {

constexpr double kFinestBlur = 0.7;  ///< px

/// Why a view keeps the pose it came with; empty: it does not. `sigmas`: its correction in sigmas of its prior.
std::string refusal(double sigmas, float residual_before, float residual_after);

/// Everything that align() works on. Its input's points lie on their surface.
class Aligner {
 public:
  Aligner(const AlignmentInput& input, const AlignmentParams& params, const Callbacks& callbacks);

  AlignmentResult run();

 private:
  // aligner.cpp: the stages, in their order
  bool hasDepth8Bit();
  void look(bool all, std::size_t points);
  bool hasOverlap();
  std::vector<double> medianDepths() const;
  void refine();
  void findClocks();
  void updateGains(PoseData data);
  std::size_t fewPoints() const;
  double startBlur() const;
  std::vector<double> levels() const;
  PoseData dataOf(const BlurredImages& images) const;
  void show(std::size_t done, std::size_t total) const;
  void log(const std::string& text) const;

  // outcome.cpp: what is kept of the corrections, and what is told of them
  void shrink(const PoseData& data);
  void refuse();
  void report();
  void warnAboutCamera(std::size_t c);
  PoseState uncorrectedViews() const;
  std::vector<float> residuals(const PoseState& state, std::vector<float>& by_view) const;
  double pixelsOf(std::size_t view, const PoseState& from) const;

  const AlignmentInput& input_;
  const AlignmentParams& params_;
  Workers workers_;
  std::vector<PointRun> runs_;
  std::size_t max_points_ = 0;  // of a view
  std::vector<std::vector<Sight>> sights_;
  Tracks tracks_;
  PosePriors priors_;
  PoseState state_, seen_at_;
  Eigen::VectorXd log_gains_;
  Eigen::VectorXf ranks_;  // of the intensities; empty: no tie to them
  AlignmentResult result_;
};

}  // namespace cloud_colorizer::alignment
