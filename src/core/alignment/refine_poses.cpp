// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause
#include <Eigen/SparseCholesky>
#include <algorithm>
#include <cmath>

#include "alignment/pose_system.hpp"
#include "alignment/poses.hpp"

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

double largestStep(const Eigen::VectorXd& step, const PosePriors& priors) {
  double largest = 0;
  for (std::size_t v = 0; v < priors.view_sigmas.size(); ++v) {
    const Twist scaled = step.segment<6>(static_cast<Eigen::Index>(6 * v)).cwiseQuotient(priors.camera_sigmas[0]);
    largest = std::max(largest, scaled.cwiseAbs().maxCoeff());
  }
  return largest;
}

std::vector<double> timeStddevs(const System& system, const PriorTerms& terms, std::size_t num_cameras) {
  std::vector<double> stddevs;
  const Eigen::SimplicialLDLT<Matrix, Eigen::Lower> factor(system.lower);
  for (std::size_t c = 0; c < num_cameras; ++c) {
    const Eigen::Index i = terms.cameraBase(c) + 6;
    const Eigen::VectorXd column = factor.solve(Eigen::VectorXd::Unit(terms.size(), i));
    stddevs.push_back(std::sqrt(std::max(0.0, column[i])));
  }
  return stddevs;
}

}  // namespace

PoseRounds refinePoses(const PoseData& data, const PosePriors& priors, int rounds, int num_threads, PoseState& state) {
  constexpr double kSmallStep = 0.004;  // of a prior's sigma
  const PriorTerms terms(data.input->views, priors);
  Evaluation current = evaluate(data, state, {}, num_threads);
  double cost = current.cost + terms.cost(state), damping = 1e-4;
  PoseRounds result;
  result.residual_first = current.residual;
  System system = assembleSystem(data, current, terms, state, num_threads);
  for (int round = 0; round < rounds; ++round) {
    Matrix damped = system.lower;
    for (Eigen::Index i = 0; i < damped.rows(); ++i) damped.coeffRef(i, i) += damping * system.data_diagonal[i];
    const Eigen::SimplicialLDLT<Matrix, Eigen::Lower> factor(damped);
    const Eigen::VectorXd step = factor.solve(-system.gradient);
    if (factor.info() != Eigen::Success || !step.allFinite()) break;
    const PoseState next = stepped(state, step, terms);
    Evaluation trial = evaluate(data, next, current, num_threads);
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
    system = assembleSystem(data, current, terms, state, num_threads);
    if (largestStep(step, priors) < kSmallStep) break;
  }
  result.residual_last = current.residual;
  result.explained = current.intensity.explained;
  result.time_stddevs = timeStddevs(system, terms, priors.camera_sigmas.size());
  return result;
}

GreyValues greyValues(const PoseData& data, const PoseState& state, int num_threads) {
  Equations<6> equations = sampleAll(data, state, num_threads).equations;
  return {std::move(equations.values), std::move(equations.weights)};
}

StateCost stateCost(const PoseData& data, const PoseState& state, const StateCost& like, int num_threads) {
  Evaluation scales;
  scales.scale = like.scale;
  const Evaluation evaluation = evaluate(data, state, scales, num_threads);
  return {evaluation.weight > 0 ? evaluation.cost / evaluation.weight : 0, evaluation.scale};
}

double searchTimeOffset(const PoseData& data, const PosePriors& priors, const PoseState& state, int num_threads) {
  constexpr int kSteps = 12;  // to either side
  double fastest = 0, prior = 0;
  for (const Twist& velocity : priors.velocities) fastest = std::max(fastest, velocity.norm());
  for (const double sigma : priors.time_sigmas) prior = std::max(prior, sigma);
  if (!(fastest > 0)) return 0;
  const double step = 4 * prior / kSteps;
  StateCost like;
  const auto costAt = [&](double offset) {
    PoseState moved = state;
    for (std::size_t v = 0; v < moved.views.size(); ++v) moved.views[v] += offset * priors.velocities[v];
    const StateCost cost = stateCost(data, moved, like, num_threads);
    if (like.scale <= 0) like = cost;
    return cost.cost;
  };
  double best = 0, least = costAt(0);
  for (int i = -kSteps; i <= kSteps; ++i) {
    const double cost = i == 0 ? least : costAt(i * step);
    if (cost < least) {
      least = cost;
      best = i * step;
    }
  }
  return best;
}

}  // namespace cloud_colorizer::alignment
