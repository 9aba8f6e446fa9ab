// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause
#include "alignment/refine_poses.hpp"

#include <algorithm>
#include <cmath>

#include "alignment/pose_system.hpp"

namespace cloud_colorizer::alignment {
namespace {

using Matrix = Eigen::SparseMatrix<double>;

PoseState stepped(const PoseState& state, const Eigen::VectorXd& step, const PriorTerms& terms) {
  PoseState next = state;
  for (std::size_t v = 0; v < next.views.size(); ++v) {
    next.views[v] += step.segment<6>(static_cast<Eigen::Index>(6 * v));
  }
  for (std::size_t c = 0; c < next.cameras.size(); ++c) {
    next.cameras[c] += step.segment<6>(terms.cameraBase(c));
    next.time_offsets[c] += step[terms.cameraBase(c) + 6];
  }
  return next;
}

std::vector<double> timeStddevs(const PoseSystem& system, const PriorTerms& terms, std::size_t num_cameras) {
  Eigen::MatrixXd units = Eigen::MatrixXd::Zero(terms.size(), static_cast<Eigen::Index>(num_cameras));
  const auto row = [&](std::size_t c) { return terms.cameraBase(c) + 6; };
  for (std::size_t c = 0; c < num_cameras; ++c) units(row(c), static_cast<Eigen::Index>(c)) = 1;
  const auto columns = solveLower(system.lower, units);
  std::vector<double> stddevs(num_cameras, INFINITY);
  for (std::size_t c = 0; columns && c < num_cameras; ++c) {
    stddevs[c] = std::sqrt(std::max(0.0, (*columns)(row(c), static_cast<Eigen::Index>(c))));
  }
  return stddevs;
}

}  // namespace

double largestStep(const Eigen::VectorXd& step, const std::vector<View>& views, const PosePriors& priors) {
  double largest = 0;
  for (std::size_t v = 0; v < views.size(); ++v) {
    const Twist scaled =
        step.segment<6>(static_cast<Eigen::Index>(6 * v)).cwiseQuotient(priors.camera_sigmas[views[v].camera]);
    largest = std::max(largest, scaled.cwiseAbs().maxCoeff());
  }
  return largest;
}

PoseRounds refinePoses(const PoseData& data, const PosePriors& priors, PoseState& state) {
  constexpr int kRounds = 4;            // the next, finer blur goes on from there
  constexpr double kSmallStep = 0.004;  // of a prior's sigma
  const PriorTerms terms(data.input->views, priors);
  PoseEquations current = poseEquations(data, state, {});
  double cost = current.cost + terms.cost(state), damping = 1e-4;
  PoseRounds result;
  result.residual_first = current.residual;
  PoseSystem system = assemblePoseSystem(data, current, terms, state);
  for (int round = 0; round < kRounds; ++round) {
    Matrix damped = system.lower;
    for (Eigen::Index i = 0; i < damped.rows(); ++i) damped.coeffRef(i, i) += damping * system.data_diagonal[i];
    const auto step = solveLower(damped, -system.gradient);
    if (!step) break;
    const PoseState next = stepped(state, *step, terms);
    PoseEquations trial = poseEquations(data, next, current);
    const double trial_cost = trial.cost + terms.cost(next);
    if (!(trial_cost < cost)) {
      damping = std::max(1e-2, 10 * damping);
      continue;
    }
    trial.weight = current.weight;
    current = std::move(trial);
    state = next;
    cost = trial_cost;
    damping /= 5;
    ++result.accepted;
    system = assemblePoseSystem(data, current, terms, state);
    if (largestStep(*step, data.input->views, priors) < kSmallStep) break;
  }
  result.residual_last = current.residual;
  result.explained = current.intensity.explained;
  result.time_stddevs = timeStddevs(system, terms, priors.camera_sigmas.size());
  return result;
}

SightValues greyValues(const PoseData& data, const PoseState& state) {
  Equations<6> equations = viewEquations(data, state).equations;
  return {std::move(equations.values), std::move(equations.weights)};
}

double searchTimeOffset(const PoseData& data, const PosePriors& priors, const PoseState& state,
                        std::vector<ClockTrial>& trials) {
  constexpr int kSteps = 12;  // to either side
  double fastest = 0, prior = 0;
  for (const Twist& velocity : priors.velocities) fastest = std::max(fastest, velocity.norm());
  for (const double sigma : priors.time_sigmas) prior = std::max(prior, sigma);
  if (!(fastest > 0)) return 0;
  const double step = 4 * prior / kSteps;
  PoseEquations like;  // the first scale counts for all, so that their costs can be compared
  const auto costAt = [&](double offset) {
    PoseState moved = state;
    for (std::size_t v = 0; v < moved.views.size(); ++v) moved.views[v] += offset * priors.velocities[v];
    const PoseEquations equations = poseEquations(data, moved, like);
    if (like.scale <= 0) like.scale = equations.scale;
    return equations.weight > 0 ? equations.cost / equations.weight : 0;
  };
  double best = 0, least = costAt(0);
  for (int i = -kSteps; i <= kSteps; ++i) {
    const double cost = i == 0 ? least : costAt(i * step);
    trials.push_back({i * step, cost});
    if (cost < least) {
      least = cost;
      best = i * step;
    }
  }
  return best;
}

}  // namespace cloud_colorizer::alignment
