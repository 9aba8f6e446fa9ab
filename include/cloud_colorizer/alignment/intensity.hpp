// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause

/// The tie to the geometry: LiDAR intensity and grey level are different quantities, but they change together.
///
/// Images that agree with each other may still be shifted over the map together; the intensity was measured with the
/// points, so it cannot. Both are taken relative to their local mean in the image (that removes range, incidence and
/// shading), and the share of the grey level's variance that bins of intensity explain (the correlation ratio) is to
/// become large: cost = -1/2 sum_k w (E[y | bin(k)])^2, whose gradient is -sum_k w E[y | bin(k)] J_k.
#pragma once

#include <cstdint>
#include <vector>

#include "cloud_colorizer/alignment/normal_equations.hpp"
#include "cloud_colorizer/alignment/poses.hpp"

namespace cloud_colorizer::alignment {

/// Ranks 0 to 1 of the intensities: no scale, no outliers. Empty for empty or constant input. NaN ranks lowest.
Eigen::VectorXf intensityRanks(const Eigen::VectorXf& intensity);

/// Observations of all views at the present poses.
struct Samples {
  Equations<6> equations;             ///< weights without robustness
  std::vector<std::uint32_t> blocks;  ///< block of the image that an observation lies in; local means are taken there
};

struct IntensityTerm {
  std::vector<Eigen::Matrix<double, 6, 6>, Eigen::aligned_allocator<Eigen::Matrix<double, 6, 6>>> hessians;  ///< by view
  std::vector<Twist> gradients;
  double cost = 0;
  double explained = 0;  ///< share of the grey level's variance that the intensity explains, 0 to 1
};

/// `noise` [grey levels]: standard deviation of what the intensity does not explain; <= 0: from the data, returned.
IntensityTerm intensityTerm(const Tracks& tracks, const Samples& samples, const Eigen::VectorXf& ranks, float& noise,
                            int num_threads);

}  // namespace cloud_colorizer::alignment
