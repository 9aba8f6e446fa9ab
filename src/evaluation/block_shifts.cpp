// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause
#include "evaluation/block_shifts.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <opencv2/imgproc.hpp>
#include <optional>

#include "base/robust.hpp"
#include "visibility/samplers.hpp"

namespace cloud_colorizer {
namespace {

using Eigen::Index;

constexpr int kBlockColumns = 8;
constexpr std::size_t kPointsOfBlock = 150;
constexpr std::array<double, 3> kBlurs = {4, 2, 1};  // px
constexpr int kShiftRounds = 6;
constexpr float kHuberLimit = 15;                    // grey levels
constexpr float kMostError = 0.33F, kMostShift = 8;  // px

/// A blurred image and its derivatives.
struct Level {
  cv::Mat1f grey, by_x, by_y;

  Level(const cv::Mat3b& image, double sigma) {
    cv::Mat1b bytes;
    cv::cvtColor(image, bytes, cv::COLOR_RGB2GRAY);
    bytes.convertTo(grey, CV_32F);
    cv::GaussianBlur(grey, grey, cv::Size(), sigma);
    const cv::Mat1f kernel = (cv::Mat1f(1, 3) << -0.5F, 0, 0.5F);
    cv::filter2D(grey, by_x, CV_32F, kernel);
    cv::filter2D(grey, by_y, CV_32F, kernel.t());
  }
};

float greyAt(const cv::Mat1f& image, const Eigen::Vector2f& pixel) {
  float value = 0;
  sampleBilinear<float>(image, pixel.x(), pixel.y(), &value);
  return value;
}

struct BlockPoint {
  Eigen::Vector2f pixel;
  float grey;  ///< of the map
};

struct Fit {
  Eigen::Vector4f unknowns = Eigen::Vector4f(0, 0, 1, 0);  ///< shift x, y, gain, offset
  float error = 0;                                         ///< px
};

/// One step; nothing where the block has no texture.
std::optional<Fit> improved(const std::vector<BlockPoint>& points, const Level& level, Fit fit) {
  Eigen::Matrix4f normal = Eigen::Matrix4f::Zero();
  Eigen::Vector4f right = Eigen::Vector4f::Zero();
  std::vector<float> residuals;
  for (const BlockPoint& point : points) {
    const Eigen::Vector2f pixel = point.pixel + fit.unknowns.head<2>();
    const float residual = greyAt(level.grey, pixel) - fit.unknowns[2] * point.grey - fit.unknowns[3];
    const float weight = std::min(1.F, kHuberLimit / std::max(1e-6F, std::abs(residual)));
    const Eigen::Vector4f jacobian(greyAt(level.by_x, pixel), greyAt(level.by_y, pixel), -point.grey, -1);
    normal += weight * jacobian * jacobian.transpose();
    right -= weight * residual * jacobian;
    residuals.push_back(std::abs(residual));
  }
  const Eigen::LDLT<Eigen::Matrix4f> solver(normal);
  if (solver.info() != Eigen::Success || !(solver.vectorD().minCoeff() > 0)) return std::nullopt;
  fit.unknowns += solver.solve(right);
  const Eigen::Matrix4f inverse = solver.solve(Eigen::Matrix4f::Identity());
  const float variance = (inverse(0, 0) + inverse(1, 1)) / 2;
  fit.error = robustSigma(std::move(residuals), 0) * std::sqrt(std::max(0.F, variance));
  if (!fit.unknowns.allFinite()) return std::nullopt;
  return fit;
}

std::optional<BlockShift> shiftOf(const std::vector<BlockPoint>& points, const std::vector<Level>& levels) {
  Fit fit;
  for (const Level& level : levels) {
    for (int round = 0; round < kShiftRounds; ++round) {
      const std::optional<Fit> next = improved(points, level, fit);
      if (!next || next->unknowns.head<2>().norm() > kMostShift) return std::nullopt;
      fit = *next;
    }
  }
  // A map that shows something else than the image has no shift.
  if (!(fit.error <= kMostError) || !(fit.unknowns[2] > 0.3F)) return std::nullopt;
  return BlockShift{fit.unknowns.head<2>().norm(), fit.error};
}

}  // namespace

std::vector<BlockShift> blockShifts(const ColoredMap& map, const SeenImage& seen, const cv::Mat3b& image) {
  const float side = static_cast<float>(image.cols) / kBlockColumns;
  std::map<std::pair<int, int>, std::vector<BlockPoint>> blocks;
  for (std::size_t k = 0; k < seen.points.size(); ++k) {
    const Index p = seen.points[k];
    if (map.colored[static_cast<std::size_t>(p)] == 0) continue;
    const auto color = map.colors.col(p);
    const Eigen::Vector2f& pixel = seen.pixels[k];
    blocks[{static_cast<int>(pixel.x() / side), static_cast<int>(pixel.y() / side)}].push_back(
        {pixel, 0.299F * color[0] + 0.587F * color[1] + 0.114F * color[2]});
  }
  std::vector<Level> levels;
  levels.reserve(kBlurs.size());
  for (const double blur : kBlurs) levels.emplace_back(image, blur);
  std::vector<BlockShift> shifts;
  for (const auto& [block, points] : blocks) {
    if (points.size() < kPointsOfBlock) continue;
    if (const auto shift = shiftOf(points, levels)) shifts.push_back(*shift);
  }
  return shifts;
}

}  // namespace cloud_colorizer
