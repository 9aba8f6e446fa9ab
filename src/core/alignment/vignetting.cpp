// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause
#include "alignment/vignetting.hpp"

#include <Eigen/Cholesky>
#include <cmath>

#include "base/robust.hpp"

namespace cloud_colorizer::alignment {
namespace {

constexpr int kSweeps = 10;             // of demeaning by view and by point
constexpr int kRobustRounds = 3;        // of weights
constexpr float kMinDeviation = 0.01F;  // of the brightness

using Columns = Eigen::Matrix<float, Eigen::Dynamic, 3>;  // log brightness, r^2, r^4: a row an observation

// Of one camera: rows of other cameras have weight 0.
struct Problem {
  Columns columns;
  std::vector<float> weights;
};

Problem makeProblem(const AlignmentInput& input, const Tracks& tracks, const PoseState& state, std::uint32_t camera,
                    const std::vector<float>& values, const std::vector<float>& weights) {
  Problem problem{Columns::Zero(static_cast<Eigen::Index>(values.size()), 3), std::vector<float>(values.size(), 0)};
  const Intrinsics& intrinsics = input.cameras[camera].intrinsics();
  const auto width = static_cast<float>(intrinsics.width), height = static_cast<float>(intrinsics.height);
  Exposure square;
  square.vignetting = {1, 0};
  for (std::size_t v = 0; v < tracks.numViews(); ++v) {
    if (input.views[v].camera != camera) continue;
    forEachSight(input, tracks, state, v, -INFINITY, [&](auto k, const auto&, const auto& projected) {
      if (!(weights[k] > 0)) return;
      const Eigen::Vector2f at = projected.pixel.template cast<float>();
      const float r2 = std::log(square.brightening(at.x(), at.y(), width, height));
      problem.columns.row(static_cast<Eigen::Index>(k)) << std::log(values[k]), r2, r2 * r2;
      problem.weights[k] = weights[k];
    });
  }
  return problem;
}

// Takes the weighted means away, by view and by point in turn, until neither is left.
Columns demeaned(const Tracks& tracks, const Problem& problem) {
  Columns columns = problem.columns;
  const auto subtract = [&](std::size_t begin, std::size_t end, const auto& observation) {
    Eigen::RowVector3f sum = Eigen::RowVector3f::Zero();
    float weight = 0;
    for (std::size_t i = begin; i < end; ++i) {
      const auto k = static_cast<Eigen::Index>(observation(i));
      sum += problem.weights[observation(i)] * columns.row(k);
      weight += problem.weights[observation(i)];
    }
    if (!(weight > 0)) return;
    for (std::size_t i = begin; i < end; ++i) columns.row(static_cast<Eigen::Index>(observation(i))) -= sum / weight;
  };
  for (int sweep = 0; sweep < kSweeps; ++sweep) {
    for (std::size_t v = 0; v < tracks.numViews(); ++v) {
      subtract(tracks.offsets[v], tracks.offsets[v + 1], [](std::size_t i) { return i; });
    }
    for (std::size_t p = 0; p < tracks.numPoints(); ++p) {
      subtract(tracks.point_offsets[p], tracks.point_offsets[p + 1],
               [&](std::size_t i) { return static_cast<std::size_t>(tracks.by_point[i]); });
    }
  }
  return columns;
}

// Coefficients that make the log brightness even.
Eigen::Vector2d regress(const Columns& columns, const std::vector<float>& weights) {
  Eigen::Matrix2d normal = 1e-9 * Eigen::Matrix2d::Identity();
  Eigen::Vector2d right = Eigen::Vector2d::Zero();
  for (Eigen::Index k = 0; k < columns.rows(); ++k) {
    const double w = weights[static_cast<std::size_t>(k)];
    const Eigen::Vector2d radii = columns.row(k).tail<2>().cast<double>();
    normal += w * radii * radii.transpose();
    right -= w * columns(k, 0) * radii;
  }
  return normal.ldlt().solve(right);
}

void reweigh(const Columns& columns, const Eigen::Vector2d& coefficients, const std::vector<float>& base,
             std::vector<float>& weights) {
  std::vector<float> residuals(base.size()), magnitudes;
  for (std::size_t k = 0; k < base.size(); ++k) {
    const auto row = columns.row(static_cast<Eigen::Index>(k));
    residuals[k] = row[0] + row.tail<2>().dot(coefficients.cast<float>().transpose());
    if (base[k] > 0) magnitudes.push_back(std::abs(residuals[k]));
  }
  const float scale = robustSigma(std::move(magnitudes), kMinDeviation);
  for (std::size_t k = 0; k < base.size(); ++k) weights[k] = base[k] * cauchyWeight(residuals[k], scale);
}

}  // namespace

std::vector<Eigen::Array2f> estimateVignetting(const AlignmentInput& input, const Tracks& tracks,
                                               const PoseState& state, const std::vector<float>& values,
                                               const std::vector<float>& weights, const Workers& workers) {
  std::vector<Eigen::Array2f> result(input.cameras.size(), Eigen::Array2f::Zero());
  if (tracks.numObservations() == 0) return result;
  workers.forEach(result.size(), [&](std::size_t camera) {
    Problem problem = makeProblem(input, tracks, state, static_cast<std::uint32_t>(camera), values, weights);
    const std::vector<float> base = problem.weights;
    Eigen::Vector2d coefficients = Eigen::Vector2d::Zero();
    for (int round = 0; round < kRobustRounds; ++round) {
      const Columns columns = demeaned(tracks, problem);
      coefficients = regress(columns, problem.weights);
      reweigh(columns, coefficients, base, problem.weights);
    }
    result[camera] = coefficients.cast<float>().array();
  });
  return result;
}

}  // namespace cloud_colorizer::alignment
