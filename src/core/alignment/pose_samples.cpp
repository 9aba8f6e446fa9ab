// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>

#include "alignment/pose_system.hpp"

namespace cloud_colorizer::alignment {
namespace {

constexpr double kEdgeMargin = 1.5;  // sigmas of the blur to keep away from depth edges
constexpr double kCellSigmas = 3.5;  // a square of this side is one independent observation
constexpr double kMinCell = 8;       // px
constexpr float kNoiseShare = 0.3F;  // of the residuals; the rest is what images get wrong together
constexpr double kBlockSigmas = 10;  // side of the blocks that local means are taken in
constexpr double kBlocksAcross = 16;

// Share of the observations that are independent: neighbours under one blur say the same.
class CellCounter {
 public:
  CellCounter(const Intrinsics& intrinsics, double sigma)
      : cell_(std::max(kMinCell, kCellSigmas * sigma)),
        columns_(static_cast<std::size_t>(intrinsics.width / cell_) + 1),
        used_(columns_ * (static_cast<std::size_t>(intrinsics.height / cell_) + 1), 0) {}
  void add(const Eigen::Vector2d& pixel) {
    ++count_;
    used_[static_cast<std::size_t>((pixel.y() + 0.5) / cell_) * columns_ +
          static_cast<std::size_t>((pixel.x() + 0.5) / cell_)] = 1;
  }
  float share() const {
    const auto cells = static_cast<float>(std::count(used_.begin(), used_.end(), 1));
    return count_ > 0 ? std::min(1.0F, cells / static_cast<float>(count_)) : 1.0F;
  }

 private:
  double cell_;
  std::size_t columns_;
  std::vector<std::uint8_t> used_;
  std::size_t count_ = 0;
};

// Number of the square block of the image that a pixel lies in.
std::uint32_t blockOf(const Eigen::Vector2d& pixel, double side, int width) {
  const auto columns = static_cast<std::uint32_t>(width / side) + 1;
  return static_cast<std::uint32_t>((pixel.y() + 0.5) / side) * columns +
         static_cast<std::uint32_t>((pixel.x() + 0.5) / side);
}

}  // namespace

ViewEquations viewEquations(const PoseData& data, const PoseState& state) {
  const Tracks& tracks = *data.tracks;
  const std::size_t count = tracks.numObservations();
  ViewEquations seen;
  seen.blocks.assign(count, 0);
  seen.right.assign(count, 0);
  Equations<6>& equations =
      seen.equations = {std::vector<float>(count, 0), std::vector<float>(count, 0),
                        std::vector<Eigen::Matrix<float, 6, 1>>(count, Eigen::Matrix<float, 6, 1>::Zero())};
  data.workers->forEach(tracks.numViews(), [&](std::size_t v) {
    if (tracks.offsets[v] == tracks.offsets[v + 1]) return;
    const auto image = data.images->get(v);
    const Eigen::Vector3d center = state.views[v].tail<3>();  // rotations turn about the uncorrected centre
    const auto gain = static_cast<float>(std::exp((*data.log_gains)[static_cast<Eigen::Index>(v)]));
    const Intrinsics& intrinsics = data.input->cameras[data.input->views[v].camera].intrinsics();
    const double sigma = data.images->sigma(v), side = std::max(kBlockSigmas * sigma, intrinsics.width / kBlocksAcross);
    CellCounter cells(intrinsics, sigma);
    const auto add = [&](std::size_t k, const Eigen::Vector3d& local, const auto& projected) {
      const GreySample grey = sampleGrey(*image, projected.pixel);
      if (!grey.valid) return;
      const Eigen::RowVector3d by_point = grey.gradient.cast<double>().transpose() * projected.jacobian;
      const Eigen::Vector3d lever = local - center;
      Eigen::Matrix<float, 6, 1> jacobian;
      jacobian << lever.cross(by_point.transpose()).template cast<float>(), by_point.transpose().template cast<float>();
      equations.values[k] = gain * grey.value;
      equations.weights[k] = tracks.sights[k].weight;
      equations.jacobians[k] = gain * jacobian;
      seen.blocks[k] = blockOf(projected.pixel, side, intrinsics.width);
      seen.right[k] = projected.pixel.x() > 0.5 * intrinsics.width;
      cells.add(projected.pixel);
    };
    forEachSight(*data.input, tracks, state, v, kEdgeMargin * sigma, add);
    const float share = cells.share() * kNoiseShare;
    for (std::uint32_t k = tracks.offsets[v]; k < tracks.offsets[v + 1]; ++k) equations.weights[k] *= share;
  });
  return seen;
}

}  // namespace cloud_colorizer::alignment
