// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause
#include "alignment/gains.hpp"

#include <algorithm>
#include <cmath>

#include "alignment/normal_equations.hpp"
#include "base/robust.hpp"

namespace cloud_colorizer::alignment {
namespace {

constexpr int kRounds = 12;
constexpr double kLogGainPrior = 0.3;       // of a view's log gain
constexpr double kIndependentShare = 0.02;  // of the points: neighbours say the same
constexpr float kMinResidual = 1;           // grey levels

// Robust weights of residuals in grey levels against `centres` (log), times value^2: equations are in logarithms.
void weigh(const Tracks& tracks, const std::vector<float>& values, const std::vector<float>& base,
           const std::vector<float>& centres, Equations<1>& equations) {
  std::vector<float> residuals(values.size(), 0), magnitudes;
  magnitudes.reserve(values.size());
  for (std::size_t k = 0; k < values.size(); ++k) {
    if (!(base[k] > 0)) continue;
    const std::uint32_t p = tracks.sights[k].point;
    if (tracks.point_offsets[p + 1] - tracks.point_offsets[p] < 2) continue;
    residuals[k] = values[k] * (equations.values[k] - centres[p]);
    magnitudes.push_back(std::abs(residuals[k]));
  }
  const float scale = robustSigma(std::move(magnitudes), kMinResidual);
  for (std::size_t k = 0; k < values.size(); ++k) {
    const float in_levels = values[k] / scale;
    equations.weights[k] = base[k] > 0 ? base[k] * cauchyWeight(residuals[k], scale) * in_levels * in_levels : 0;
  }
}

std::optional<Eigen::MatrixXd> solveGains(const Tracks& tracks, const Equations<1>& equations,
                                          const Eigen::VectorXd& current, const Workers& workers) {
  const NormalEquations normal = assemble(tracks, equations, workers);
  const auto size = static_cast<Eigen::Index>(tracks.numViews());
  Eigen::SparseMatrix<double> matrix(size, size);
  matrix.setFromTriplets(normal.lower.begin(), normal.lower.end());
  matrix *= kIndependentShare;
  const double stiffness = 1 / (kLogGainPrior * kLogGainPrior);
  for (Eigen::Index v = 0; v < size; ++v) matrix.coeffRef(v, v) += stiffness;
  return solveLower(matrix, -kIndependentShare * normal.gradient - stiffness * current);
}

// The mean brightness of what was seen stays what it was.
void centre(const std::vector<float>& values, const std::vector<float>& weights, const Tracks& tracks,
            Eigen::VectorXd& gains) {
  double before = 0, after = 0;
  for (std::size_t k = 0; k < weights.size(); ++k) {
    if (!(weights[k] > 0)) continue;
    before += values[k];
    after += values[k] * std::exp(gains[tracks.views[k]]);
  }
  if (before > 0 && after > 0) gains.array() += std::log(before / after);
}

}  // namespace

std::vector<float> pointMedians(const Tracks& tracks, const std::vector<float>& values,
                                const std::vector<float>& weights) {
  std::vector<float> medians(tracks.numPoints(), 0), seen;
  for (std::size_t p = 0; p < tracks.numPoints(); ++p) {
    seen.clear();
    for (std::uint32_t i = tracks.point_offsets[p]; i < tracks.point_offsets[p + 1]; ++i) {
      const std::uint32_t k = tracks.by_point[i];
      if (weights[k] > 0) seen.push_back(values[k]);
    }
    medians[p] = median(seen);
  }
  return medians;
}

Eigen::VectorXd estimateLogGains(const Tracks& tracks, const std::vector<float>& values,
                                 const std::vector<float>& weights, double max_gain, const Workers& workers) {
  Eigen::VectorXd gains = Eigen::VectorXd::Zero(static_cast<Eigen::Index>(tracks.numViews()));
  if (tracks.numObservations() == 0) return gains;
  const std::size_t count = tracks.numObservations();
  Equations<1> equations{std::vector<float>(count), std::vector<float>(count),
                         std::vector<Eigen::Matrix<float, 1, 1>>(count, Eigen::Matrix<float, 1, 1>::Ones())};
  for (int round = 0; round < kRounds; ++round) {
    for (std::size_t k = 0; k < count; ++k) {
      equations.values[k] = weights[k] > 0 ? std::log(values[k]) + static_cast<float>(gains[tracks.views[k]]) : 0;
    }
    std::vector<float> centres;
    if (round < 3) {  // the median until the weights are good
      centres = pointMedians(tracks, equations.values, weights);
    } else {
      const Eigen::VectorXf means = pointMeans(tracks, equations).cast<float>();
      centres.assign(means.data(), means.data() + means.size());
    }
    weigh(tracks, values, weights, centres, equations);
    const auto step = solveGains(tracks, equations, gains, workers);
    if (!step) break;
    gains += *step;
    if (step->size() > 0 && step->cwiseAbs().maxCoeff() < 1e-5 && round > 3) break;
  }
  centre(values, weights, tracks, gains);
  const double limit = std::log(max_gain);
  return gains.cwiseMax(-limit).cwiseMin(limit);
}

}  // namespace cloud_colorizer::alignment
