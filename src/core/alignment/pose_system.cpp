// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause
#include "alignment/pose_system.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "alignment/gains.hpp"
#include "alignment/normal_equations.hpp"
#include "base/robust.hpp"

namespace cloud_colorizer::alignment {
namespace {

constexpr float kMinScale = 1;  // grey levels: residuals below it are as good as none

// Residuals against `centres` of the observations whose point has another one; NaN for the others.
std::vector<float> residualsTo(const Tracks& tracks, const Equations<6>& equations, const std::vector<float>& centres) {
  std::vector<float> residuals(tracks.numObservations(), std::nanf(""));
  for (std::size_t p = 0; p < tracks.numPoints(); ++p) {
    int seen = 0;
    const std::uint32_t begin = tracks.point_offsets[p], end = tracks.point_offsets[p + 1];
    for (std::uint32_t i = begin; i < end; ++i) seen += equations.weights[tracks.by_point[i]] > 0;
    if (seen < 2) continue;
    for (std::uint32_t i = begin; i < end; ++i) {
      const std::uint32_t k = tracks.by_point[i];
      if (equations.weights[k] > 0) residuals[k] = equations.values[k] - centres[p];
    }
  }
  return residuals;
}

float medianMagnitude(const std::vector<float>& residuals) {
  std::vector<float> magnitudes;
  magnitudes.reserve(residuals.size());
  for (const float r : residuals) {
    if (!std::isnan(r)) magnitudes.push_back(std::abs(r));
  }
  return median(std::move(magnitudes));
}

}  // namespace

PoseEquations poseEquations(const PoseData& data, const PoseState& state, const PoseEquations& like) {
  const Tracks& tracks = *data.tracks;
  const float scale = like.scale;
  const double weight = like.weight;
  PoseEquations result;
  ViewEquations seen = viewEquations(data, state);
  if (data.ranks) result.intensity = intensityTerm(tracks, seen, *data.ranks, *data.workers);
  Equations<6>& equations = result.equations = std::move(seen.equations);
  const std::vector<float> medians = pointMedians(tracks, equations.values, equations.weights);
  std::vector<float> residuals = residualsTo(tracks, equations, medians);
  result.residual = medianMagnitude(residuals);
  result.scale = scale > 0 ? scale : robustSigma({result.residual}, kMinScale);
  const std::vector<float> base = equations.weights;
  for (std::size_t k = 0; k < base.size(); ++k) {
    const bool shared = !std::isnan(residuals[k]);
    equations.weights[k] =
        shared ? base[k] * cauchyWeight(residuals[k], result.scale) / (result.scale * result.scale) : 0;
  }
  const Eigen::VectorXd means = pointMeans(tracks, equations);
  const double c = 2.385;
  double cost = 0;
  for (std::size_t k = 0; k < base.size(); ++k) {
    if (!(equations.weights[k] > 0)) continue;
    const double x = (equations.values[k] - means[tracks.sights[k].point]) / (c * result.scale);
    cost += 0.5 * base[k] * c * c * std::log1p(x * x);
    result.weight += base[k];
  }
  if (result.weight > 0) result.cost = cost * (weight > 0 ? weight / result.weight : 1);
  result.cost += result.intensity.cost;
  return result;
}

Twist PriorTerms::deviation(const PoseState& state, std::size_t v) const {
  const std::uint32_t c = views_[v].camera;
  return (state.views[v] - state.cameras[c] - state.time_offsets[c] * priors_.velocities[v])
      .cwiseQuotient(priors_.view_sigmas[v]);
}

template <class Visit>
void PriorTerms::forEach(const PoseState& state, Visit&& visit) const {
  for (std::size_t v = 0; v < views_.size(); ++v) {
    const std::uint32_t c = views_[v].camera;
    const auto d = static_cast<int>(6 * v), e = static_cast<int>(cameraBase(c)), tau = e + 6;
    const Twist deviation = this->deviation(state, v);
    for (int i = 0; i < 6; ++i) {
      visit(deviation[i], 1 / priors_.view_sigmas[v][i],
            std::array{Unknown{d + i, 1}, Unknown{e + i, -1}, Unknown{tau, -priors_.velocities[v][i]}});
    }
    const std::size_t u = priors_.previous[v];
    if (priors_.step_sigmas.empty() || u == v) continue;
    const auto first = static_cast<int>(6 * std::min(u, v)), second = static_cast<int>(6 * std::max(u, v));
    const Twist sigma = priors_.step_sigmas[c];
    const Twist step = (state.views[std::max(u, v)] - state.views[std::min(u, v)]).cwiseQuotient(sigma);
    for (int i = 0; i < 6; ++i)
      visit(step[i], 1 / sigma[i], std::array{Unknown{first + i, -1}, Unknown{second + i, 1}});
  }
  for (std::size_t c = 0; c < state.cameras.size(); ++c) {
    const auto e = static_cast<int>(cameraBase(c));
    for (int i = 0; i < 6; ++i) {
      const double sigma = priors_.camera_sigmas[c][i];
      visit(state.cameras[c][i] / sigma, 1 / sigma, std::array{Unknown{e + i, 1}});
    }
    visit(state.time_offsets[c] / priors_.time_sigmas[c], 1 / priors_.time_sigmas[c], std::array{Unknown{e + 6, 1}});
  }
}

double PriorTerms::cost(const PoseState& state) const {
  double sum = 0;
  forEach(state, [&](double deviation, double, const auto&) { sum += deviation * deviation; });
  return 0.5 * sum;
}

void PriorTerms::addTo(const PoseState& state, std::vector<Eigen::Triplet<double>>& lower,
                       Eigen::VectorXd& gradient) const {
  forEach(state, [&](double deviation, double scale, const auto& unknowns) {
    for (auto row = unknowns.begin(); row != unknowns.end(); ++row) {
      gradient[row->index] += scale * row->factor * deviation;
      for (auto column = unknowns.begin(); column <= row; ++column) {
        lower.emplace_back(row->index, column->index, scale * scale * row->factor * column->factor);
      }
    }
  });
}

PoseSystem assemblePoseSystem(const PoseData& data, const PoseEquations& equations, const PriorTerms& terms,
                              const PoseState& state) {
  NormalEquations normal = assemble(*data.tracks, equations.equations, *data.workers);
  PoseSystem system;
  system.gradient = Eigen::VectorXd::Zero(terms.size());
  system.gradient.head(normal.gradient.size()) = normal.gradient;
  for (std::size_t v = 0; v < equations.intensity.gradients.size(); ++v) {
    const auto base = static_cast<int>(6 * v);
    system.gradient.segment<6>(base) += equations.intensity.gradients[v];
    for (int r = 0; r < 6; ++r) {
      for (int c = 0; c <= r; ++c) normal.lower.emplace_back(base + r, base + c, equations.intensity.hessians[v](r, c));
    }
  }
  system.data_diagonal = Eigen::VectorXd::Zero(terms.size());
  for (const auto& entry : normal.lower) {
    if (entry.row() == entry.col()) system.data_diagonal[entry.row()] += entry.value();
  }
  terms.addTo(state, normal.lower, system.gradient);
  system.lower.resize(terms.size(), terms.size());
  system.lower.setFromTriplets(normal.lower.begin(), normal.lower.end());
  return system;
}

}  // namespace cloud_colorizer::alignment
