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

// The observations of one view, as they enter the equations.
class ViewSampler {
 public:
  ViewSampler(const PoseData& data, std::size_t view, const Twist& correction)
      : data_(data),
        camera_(data.input->cameras[data.input->views[view].camera]),
        camera_from_map_(correctedPose(data.input->views[view], correction).inverse()),
        translation_(correction.tail<3>()),
        image_(data.images->get(view)) {}

  struct Row {
    float value = 0, weight = 0;
    Eigen::Matrix<float, 6, 1> jacobian = Eigen::Matrix<float, 6, 1>::Zero();
    Eigen::Vector2d pixel{0, 0};
  };

  Row operator()(const Sight& sight) const {
    Row row;
    if (sight.edge_distance < kEdgeMargin * data_.sigma) return row;
    const Eigen::Vector3d local = camera_from_map_ * data_.input->points.col(sight.point).cast<double>();
    const auto projected = camera_.linearize(local);
    if (!projected) return row;
    const GreySample grey = sampleGrey(*image_, projected->pixel);
    if (!grey.valid) return row;
    const Eigen::RowVector3d by_point = grey.gradient.cast<double>().transpose() * projected->jacobian;
    const Eigen::Vector3d lever = local - translation_;  // rotations turn about the uncorrected centre
    row.value = grey.value;
    row.weight = sight.weight;
    row.pixel = projected->pixel;
    row.jacobian << lever.cross(by_point.transpose()).cast<float>(), by_point.transpose().cast<float>();
    return row;
  }

 private:
  const PoseData& data_;
  const Camera& camera_;
  Eigen::Isometry3d camera_from_map_;
  Eigen::Vector3d translation_;
  std::shared_ptr<const BlurredImage> image_;
};

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
  Equations<6>& equations =
      seen.equations = {std::vector<float>(count, 0), std::vector<float>(count, 0),
                        std::vector<Eigen::Matrix<float, 6, 1>>(count, Eigen::Matrix<float, 6, 1>::Zero())};
  data.workers->forEach(tracks.numViews(), [&](std::size_t v) {
    if (tracks.offsets[v] == tracks.offsets[v + 1]) return;
    const ViewSampler sampler(data, v, state.views[v]);
    const auto gain = static_cast<float>(std::exp((*data.log_gains)[static_cast<Eigen::Index>(v)]));
    const Intrinsics& intrinsics = data.input->cameras[data.input->views[v].camera].intrinsics();
    const double side = std::max(kBlockSigmas * data.sigma, intrinsics.width / kBlocksAcross);
    CellCounter cells(intrinsics, data.sigma);
    for (std::uint32_t k = tracks.offsets[v]; k < tracks.offsets[v + 1]; ++k) {
      const auto row = sampler(tracks.sights[k]);
      if (!(row.weight > 0)) continue;
      equations.values[k] = gain * row.value;
      equations.weights[k] = row.weight;
      equations.jacobians[k] = gain * row.jacobian;
      seen.blocks[k] = blockOf(row.pixel, side, intrinsics.width);
      cells.add(row.pixel);
    }
    const float share = cells.share() * kNoiseShare;
    for (std::uint32_t k = tracks.offsets[v]; k < tracks.offsets[v + 1]; ++k) equations.weights[k] *= share;
  });
  return seen;
}

}  // namespace cloud_colorizer::alignment
