// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause

/// The joint problem of the poses at one state: residuals, robust weights, priors, normal equations.
#pragma once

#include <Eigen/SparseCore>
#include <algorithm>
#include <cmath>
#include <vector>

#include "alignment/intensity.hpp"
#include "alignment/refine_poses.hpp"

namespace cloud_colorizer::alignment {

/// What all views see at a state, without robustness.
ViewEquations viewEquations(const PoseData& data, const PoseState& state);

struct PoseEquations {
  Equations<6> equations;  ///< robust weights
  double cost = 0;         ///< mean a unit of weight, times the weight of the first ones; without priors
  double weight = 0;
  float scale = 0, residual = 0;  ///< grey levels
  IntensityTerm intensity;
};

/// `like`: equations whose scales are kept, so that the costs can be compared; a default one for none. `groups`:
/// see IntensityTerm.
PoseEquations poseEquations(const PoseData& data, const PoseState& state, const PoseEquations& like,
                            const PointGroups& groups = {});

/// Unknowns: the views' corrections, then the cameras' with their time offsets.
class PriorTerms {
 public:
  PriorTerms(const std::vector<View>& views, const PosePriors& priors) : views_(views), priors_(priors) {}

  Eigen::Index size() const { return cameraBase(priors_.camera_sigmas.size()); }
  Eigen::Index cameraBase(std::size_t camera) const {
    return static_cast<Eigen::Index>(6 * views_.size() + 7 * camera);
  }

  Twist deviation(const PoseState& state, std::size_t v) const {
    const std::uint32_t c = views_[v].camera;
    return (state.views[v] - state.cameras[c] - state.time_offsets[c] * priors_.velocities[v])
        .cwiseQuotient(priors_.view_sigmas[v]);
  }

  double cost(const PoseState& state) const {
    double sum = 0;
    for (std::size_t v = 0; v < views_.size(); ++v) {
      sum += deviation(state, v).squaredNorm();
      if (hasStep(v)) sum += stepDeviation(state, v).squaredNorm();
    }
    for (std::size_t c = 0; c < state.cameras.size(); ++c) {
      sum += state.cameras[c].cwiseQuotient(priors_.camera_sigmas[c]).squaredNorm();
      sum += std::pow(state.time_offsets[c] / priors_.time_sigmas[c], 2);
    }
    return 0.5 * sum;
  }

  void addTo(const PoseState& state, std::vector<Eigen::Triplet<double>>& lower, Eigen::VectorXd& gradient) const {
    for (std::size_t v = 0; v < views_.size(); ++v) {
      addView(state, v, lower, gradient);
      if (hasStep(v)) addStep(state, v, lower, gradient);
    }
    for (std::size_t c = 0; c < state.cameras.size(); ++c) {
      const auto base = static_cast<int>(cameraBase(c));
      for (int i = 0; i < 6; ++i) {
        const double s2 = std::pow(priors_.camera_sigmas[c][i], -2);
        lower.emplace_back(base + i, base + i, s2);
        gradient[base + i] += s2 * state.cameras[c][i];
      }
      const double s2 = std::pow(priors_.time_sigmas[c], -2);
      lower.emplace_back(base + 6, base + 6, s2);
      gradient[base + 6] += s2 * state.time_offsets[c];
    }
  }

 private:
  // Of (d - e - tau u)^2 / sigma^2 in each component: rows for d, e and tau.
  void addView(const PoseState& state, std::size_t v, std::vector<Eigen::Triplet<double>>& lower,
               Eigen::VectorXd& gradient) const {
    const auto d = static_cast<int>(6 * v), e = static_cast<int>(cameraBase(views_[v].camera)), tau = e + 6;
    const Twist deviation = this->deviation(state, v);
    for (int i = 0; i < 6; ++i) {
      const double s = 1 / priors_.view_sigmas[v][i], s2 = s * s, u = priors_.velocities[v][i];
      lower.emplace_back(d + i, d + i, s2);
      lower.emplace_back(e + i, d + i, -s2);
      lower.emplace_back(e + i, e + i, s2);
      lower.emplace_back(tau, d + i, -s2 * u);
      lower.emplace_back(tau, e + i, s2 * u);
      lower.emplace_back(tau, tau, s2 * u * u);
      gradient[d + i] += s * deviation[i];
      gradient[e + i] -= s * deviation[i];
      gradient[tau] -= s * u * deviation[i];
    }
  }

  bool hasStep(std::size_t v) const { return !priors_.step_sigmas.empty() && priors_.previous[v] != v; }

  Twist stepDeviation(const PoseState& state, std::size_t v) const {
    return (state.views[v] - state.views[priors_.previous[v]]).cwiseQuotient(priors_.step_sigmas[views_[v].camera]);
  }

  // Of (d_v - d_u)^2 / sigma^2 in each component, u the view before.
  void addStep(const PoseState& state, std::size_t v, std::vector<Eigen::Triplet<double>>& lower,
               Eigen::VectorXd& gradient) const {
    const std::size_t u = priors_.previous[v];
    const auto a = static_cast<int>(6 * v), b = static_cast<int>(6 * u);
    const Twist deviation = stepDeviation(state, v);
    for (int i = 0; i < 6; ++i) {
      const double s = 1 / priors_.step_sigmas[views_[v].camera][i], s2 = s * s;
      lower.emplace_back(a + i, a + i, s2);
      lower.emplace_back(b + i, b + i, s2);
      lower.emplace_back(std::max(a, b) + i, std::min(a, b) + i, -s2);
      gradient[a + i] += s * deviation[i];
      gradient[b + i] -= s * deviation[i];
    }
  }

  const std::vector<View>& views_;
  const PosePriors& priors_;
};

struct PoseSystem {
  Eigen::SparseMatrix<double> lower;
  Eigen::VectorXd data_diagonal;  ///< of the data alone: damping must not act on stiff priors
  Eigen::VectorXd gradient;
};
PoseSystem assemblePoseSystem(const PoseData& data, const PoseEquations& equations, const PriorTerms& terms,
                              const PoseState& state);

}  // namespace cloud_colorizer::alignment
