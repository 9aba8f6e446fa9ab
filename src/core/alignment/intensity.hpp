// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause

/// The tie to the geometry: LiDAR intensity and grey level are different quantities, but they change together.
///
/// Images that agree with each other may still be shifted over the map together; the intensity was measured with the
/// points, so it cannot. Both are taken relative to their local mean in the image (that removes range, incidence and
/// shading), and the share R^2 of the grey level's variance that bins of intensity explain (the correlation ratio) is
/// to become large: cost = n/2 log(1 - R^2), the mutual information of Gaussian noise. It does not change with the
/// contrast, so nothing is gained by moving to where the image is smooth or rough. Gradient: with the local values y
/// and their variance s^2 unexplained, sum_k (R^2 y_k - E[y | bin(k)]) J_k / s^2.
#pragma once

#include <cstdint>
#include <vector>

#include "alignment/motion.hpp"
#include "alignment/normal_equations.hpp"

namespace cloud_colorizer::alignment {

/// Ranks 0 to 1 of the intensities: no scale, no outliers. Empty for empty or constant input. NaN ranks lowest.
Eigen::VectorXf intensityRanks(const Eigen::VectorXf& intensity);

/// Observations of all views at the present poses.
struct ViewEquations {
  Equations<6> equations;             ///< weights without robustness
  std::vector<std::uint32_t> blocks;  ///< block of the image that an observation lies in; local means are taken there
  std::vector<std::uint8_t> right;    ///< whether in the right half of the image
};

struct IntensityTerm {
  std::vector<Eigen::Matrix<double, 6, 6>, Eigen::aligned_allocator<Eigen::Matrix<double, 6, 6>>>
      hessians;  ///< by view
  std::vector<Twist> gradients;
  double cost = 0;
  double explained = 0;  ///< share of the grey level's variance that the intensity explains, 0 to 1
};

IntensityTerm intensityTerm(const Tracks& tracks, const ViewEquations& samples, const Eigen::VectorXf& ranks,
                            const Workers& workers);

/// Of each observation, in the mean variance of all: its squared distance to what the bins of intensity predict, less
/// its square; the mean is -R^2 of a prediction. Bins are learned with the weights `learn`. NaN where there is none.
std::vector<float> unexplainedShares(const Tracks& tracks, const ViewEquations& seen, const Eigen::VectorXf& ranks,
                                     const std::vector<float>& learn, const Workers& workers);

}  // namespace cloud_colorizer::alignment
