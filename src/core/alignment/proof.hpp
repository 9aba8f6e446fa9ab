// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause

/// Proof: what points that took no part in an estimate say of its corrections.
///
/// The map is cut into blocks, and one block of three takes no part in any estimate. There each view is predicted from
/// the other views of the same points (leave one view out), and its intensity from what the estimate learned of it,
/// once with a correction and once without. The correction is proven where the prediction is better by more than it
/// scatters from block to block. This needs no model of the noise: shading, wrong surfaces and a drifting map scatter
/// as well.
#pragma once

#include <vector>

#include "alignment/refine_poses.hpp"

namespace cloud_colorizer::alignment {

/// Cubes of the map, as numbers by point in [0, kCount); cubes far apart may share one.
struct Blocks {
  static constexpr std::uint32_t kCount = 3 * 512;
  std::vector<std::uint16_t> of_point;  ///< empty: nothing is held back

  bool isHeldBack(std::uint32_t point) const { return !of_point.empty() && of_point[point] % 3 == 0; }
};
/// `side`: of a cube, m.
Blocks makeBlocks(const Points& points, double side);
/// The weights of observations, 0 where the point is held back.
std::vector<float> estimateWeights(const Tracks& tracks, const Blocks& blocks, std::vector<float> weights);

/// How much better held-back observations are predicted with a correction.
struct Improvement {
  double without = 0, with = 0;  ///< mean errors
  double error = 0;              ///< standard error of their difference, by the scatter of the blocks
  int blocks = 0;                ///< with such observations

  double mean() const { return without - with; }
  bool isProven() const;     ///< better by some standard errors
  bool isDisproven() const;  ///< worse by as many
  bool isBetter() const;     ///< by more than one standard error
};

/// Of one observation.
struct Errors {
  std::uint16_t block;
  float without, with;
};
Improvement improvement(const std::vector<Errors>& errors);

/// What is seen at a state, by observation.
struct Showing {
  std::vector<float> values;        ///< after the gains that suit this state
  std::vector<float> weights;       ///< 0 where nothing is seen
  std::vector<float> unexplained;   ///< by the intensity, see unexplainedShares(); empty without intensity
  std::vector<std::uint8_t> right;  ///< in the right half of the image; empty: halves do not matter
};
Showing show(const PoseData& data, const Blocks& blocks, const PoseState& state);

/// Of all views, some are to be tried without a correction, and some count.
struct Choice {
  std::vector<std::uint8_t> without;  ///< by view
  std::vector<std::size_t> counted;
  enum Half { kLeft = 0, kRight = 1, kBoth = 2 } half = kBoth;  ///< of the images, which counts

  static Choice ofView(std::size_t view, std::size_t num_views);
  static Choice ofCamera(std::uint32_t camera, const std::vector<View>& views);
  static Choice ofAll(std::size_t num_views);
};

/// Of the whole image, and of either half of it.
struct Improvements {
  Improvement all, left, right;
};

/// Proof by the agreement of the views [unit of the values], and by the intensity.
struct Evidence {
  Improvements agreement, tie;
  bool has_halves = false;

  /// Views may prove it where they see both halves of the image, and neither half speaks against it: a strip at one end
  /// tells nothing of the other. So may the intensity alone where either half is better by more than its scatter. What
  /// views or intensity disprove is not proven.
  bool isProven() const;
  /// By more than one scatter, of what is proven piece by piece.
  bool isBetter() const;
  /// What tells more: the views, and where there are too few blocks of them the intensity.
  const Improvement& main() const;
};
/// Each observation against the median of the others of its point. `before`, `after`: of all views without and with the
/// correction.
Evidence evidence(const Tracks& tracks, const Blocks& blocks, const Showing& before, const Showing& after,
                  const Choice& choice);

}  // namespace cloud_colorizer::alignment
