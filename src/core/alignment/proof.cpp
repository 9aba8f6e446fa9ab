// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause
#include "alignment/proof.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "alignment/gains.hpp"
#include "alignment/pose_system.hpp"
#include "base/random.hpp"

namespace cloud_colorizer::alignment {
namespace {

constexpr double kSigmas = 2.5;  // standard errors by which an improvement must exceed its scatter
constexpr int kMinBlocks = 16;   // that tell a scatter

// Of an even number the mean of the middle two, so that no view is preferred. Reorders the values.
float middle(std::vector<float>& values) {
  const auto upper = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), upper, values.end());
  return values.size() % 2 == 1 ? *upper : 0.5F * (*upper + *std::max_element(values.begin(), upper));
}

// One observation against the others of its point, without and with a correction.
class Prediction {
 public:
  Prediction(const Tracks& tracks, const Showing& before, const Showing& after,
             const std::vector<std::uint8_t>& without)
      : tracks_(tracks), before_(before), after_(after), without_(without) {}

  bool isSeen(std::uint32_t k) const { return before_.weights[k] > 0 && after_.weights[k] > 0; }

  // Whether there are others.
  bool predict(std::uint32_t k) {
    old_.clear();
    new_.clear();
    const std::uint32_t p = tracks_.sights[k].point;
    for (std::uint32_t i = tracks_.point_offsets[p]; i < tracks_.point_offsets[p + 1]; ++i) {
      const std::uint32_t other = tracks_.by_point[i];
      if (other == k || !isSeen(other)) continue;
      old_.push_back(valueWithout(other));
      new_.push_back(after_.values[other]);
    }
    if (old_.empty()) return false;
    error_without = std::abs(valueWithout(k) - middle(old_));
    error_with = std::abs(after_.values[k] - middle(new_));
    return true;
  }

  float error_without = 0, error_with = 0;

 private:
  float valueWithout(std::uint32_t k) const {
    return without_[tracks_.views[k]] != 0 ? before_.values[k] : after_.values[k];
  }

  const Tracks& tracks_;
  const Showing &before_, &after_;
  const std::vector<std::uint8_t>& without_;
  std::vector<float> old_, new_;
};

Improvements byHalf(std::vector<Errors> (&halves)[2]) {
  Improvements result{{}, improvement(halves[0]), improvement(halves[1])};
  halves[0].insert(halves[0].end(), halves[1].begin(), halves[1].end());
  result.all = improvement(halves[0]);
  return result;
}

}  // namespace

Blocks makeBlocks(const Points& points, double side) {
  Blocks blocks;
  blocks.of_point.resize(static_cast<std::size_t>(points.cols()));
  for (std::size_t p = 0; p < blocks.of_point.size(); ++p) {
    const Eigen::Vector3d cell = points.col(static_cast<Eigen::Index>(p)).cast<double>() / side;
    std::uint64_t hash = 0;
    for (int axis = 0; axis < 3; ++axis) {
      hash = mixBits(hash ^ static_cast<std::uint64_t>(static_cast<std::int64_t>(std::floor(cell[axis]))));
    }
    blocks.of_point[p] = static_cast<std::uint16_t>(hash % Blocks::kCount);
  }
  return blocks;
}

std::vector<float> estimateWeights(const Tracks& tracks, const Blocks& blocks, std::vector<float> weights) {
  for (std::size_t k = 0; k < weights.size(); ++k) {
    if (blocks.isHeldBack(tracks.sights[k].point)) weights[k] = 0;
  }
  return weights;
}

bool Improvement::isProven() const {
  return blocks >= kMinBlocks && mean() > kSigmas * error;
}

bool Improvement::isBetter() const {
  return blocks >= kMinBlocks && mean() > error;
}

bool Improvement::isDisproven() const {
  return blocks >= kMinBlocks && mean() < -kSigmas * error;
}

Improvement improvement(const std::vector<Errors>& errors) {
  std::vector<Eigen::Vector3d> blocks(Blocks::kCount, Eigen::Vector3d::Zero());
  for (const Errors& e : errors) blocks[e.block] += Eigen::Vector3d(e.without, e.with, 1);
  Improvement result;
  Eigen::Vector3d total = Eigen::Vector3d::Zero();
  for (const Eigen::Vector3d& block : blocks) {
    total += block;
    result.blocks += block[2] > 0;
  }
  if (result.blocks < 2) return result;
  result.without = total[0] / total[2];
  result.with = total[1] / total[2];
  double squares = 0;
  for (const auto& block : blocks) squares += std::pow(block[0] - block[1] - result.mean() * block[2], 2);
  result.error = std::sqrt(squares * result.blocks / (result.blocks - 1.0)) / total[2];
  return result;
}

Showing show(const PoseData& data, const Blocks& blocks, const PoseState& state) {
  PoseData without_gains = data;
  const Eigen::VectorXd none = Eigen::VectorXd::Zero(data.log_gains->size());
  without_gains.log_gains = &none;
  const Tracks& tracks = *data.tracks;
  ViewEquations seen = viewEquations(without_gains, state);
  std::vector<float>& values = seen.equations.values;
  const std::vector<float> part = estimateWeights(tracks, blocks, seen.equations.weights);
  const Eigen::VectorXd log_gains = estimateLogGains(tracks, values, part, kMaxGain, *data.workers);
  for (std::size_t k = 0; k < values.size(); ++k) {
    values[k] *= static_cast<float>(std::exp(log_gains[static_cast<Eigen::Index>(tracks.views[k])]));
  }
  Showing showing;
  if (data.ranks) showing.unexplained = unexplainedShares(tracks, seen, *data.ranks, part, *data.workers);
  showing.values = std::move(values);
  showing.weights = std::move(seen.equations.weights);
  showing.right = std::move(seen.right);
  return showing;
}

bool Evidence::isProven() const {
  const auto holds = [](const Improvement& half) { return half.blocks >= kMinBlocks && half.mean() > -half.error; };
  const bool agrees = agreement.all.isProven() && (!has_halves || (holds(agreement.left) && holds(agreement.right)));
  const bool tied = tie.all.isProven() && tie.left.isBetter() && tie.right.isBetter();
  return (agrees && !tie.all.isDisproven()) || (tied && !agreement.all.isDisproven());
}

bool Evidence::isBetter() const {
  return (agreement.all.isBetter() && !tie.all.isDisproven()) || (tie.all.isBetter() && !agreement.all.isDisproven());
}

const Improvement& Evidence::main() const {
  return agreement.all.blocks >= kMinBlocks ? agreement.all : tie.all;
}

Choice Choice::ofView(std::size_t view, std::size_t num_views) {
  Choice choice{std::vector<std::uint8_t>(num_views, 0), {view}, kBoth};
  choice.without[view] = 1;
  return choice;
}

Choice Choice::ofCamera(std::uint32_t camera, const std::vector<View>& views) {
  Choice choice;
  for (std::size_t v = 0; v < views.size(); ++v) {
    choice.without.push_back(views[v].camera == camera);
    if (views[v].camera == camera) choice.counted.push_back(v);
  }
  return choice;
}

Choice Choice::ofAll(std::size_t num_views) {
  Choice choice{std::vector<std::uint8_t>(num_views, 1), std::vector<std::size_t>(num_views), kBoth};
  std::iota(choice.counted.begin(), choice.counted.end(), std::size_t{0});
  return choice;
}

Evidence evidence(const Tracks& tracks, const Blocks& blocks, const Showing& before, const Showing& after,
                  const Choice& choice) {
  std::vector<Errors> views[2], ties[2];
  Prediction prediction(tracks, before, after, choice.without);
  for (const std::size_t v : choice.counted) {
    for (std::uint32_t k = tracks.offsets[v]; k < tracks.offsets[v + 1]; ++k) {
      const std::uint32_t point = tracks.sights[k].point;
      if (!blocks.isHeldBack(point) || !prediction.isSeen(k)) continue;
      const std::uint8_t right = after.right.empty() ? 0 : after.right[k];
      if (choice.half != Choice::kBoth && right != choice.half) continue;
      const std::uint16_t block = blocks.of_point[point];
      if (prediction.predict(k)) views[right].push_back({block, prediction.error_without, prediction.error_with});
      if (before.unexplained.empty() || std::isnan(before.unexplained[k] + after.unexplained[k])) continue;
      ties[right].push_back({block, before.unexplained[k], after.unexplained[k]});
    }
  }
  Evidence result{byHalf(views), byHalf(ties), !after.right.empty()};
  // An intensity that predicts nothing has no say.
  if (std::min(result.tie.all.without, result.tie.all.with) >= 0) result.tie = {};
  return result;
}

}  // namespace cloud_colorizer::alignment
