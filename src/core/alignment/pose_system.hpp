// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause

/// The joint problem of the poses at one state: residuals, robust weights, priors, normal equations.
#pragma once

#include <Eigen/SparseCore>
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

/// `like`: equations whose scales are kept, so that the costs can be compared; a default one for none.
PoseEquations poseEquations(const PoseData& data, const PoseState& state, const PoseEquations& like);

/// Unknowns: the views' corrections, then the cameras' with their time offsets. Each prior is a square of a few of
/// them:
/// ((sum_j factor_j x_j) / sigma)^2.
class PriorTerms {
 public:
  PriorTerms(const std::vector<View>& views, const PosePriors& priors) : views_(views), priors_(priors) {}

  Eigen::Index size() const { return cameraBase(priors_.camera_sigmas.size()); }
  Eigen::Index cameraBase(std::size_t camera) const {
    return static_cast<Eigen::Index>(6 * views_.size() + 7 * camera);
  }

  Twist deviation(const PoseState& state, std::size_t v) const;  ///< of a view from what is expected, in sigmas
  double cost(const PoseState& state) const;
  void addTo(const PoseState& state, std::vector<Eigen::Triplet<double>>& lower, Eigen::VectorXd& gradient) const;

 private:
  struct Unknown {
    int index;
    double factor;
  };
  /// Calls visit(value / sigma, 1 / sigma, unknowns) for every square, unknowns by ascending index.
  template <class Visit>
  void forEach(const PoseState& state, Visit&& visit) const;

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
