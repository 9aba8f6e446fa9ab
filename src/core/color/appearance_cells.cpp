// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause
#include "color/appearance_cells.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <utility>

#include "base/robust.hpp"

namespace cloud_colorizer {
namespace {

using Eigen::Vector3f;

constexpr float kPrior = 0.003F;     // mu: share of the weight
constexpr float kLeastGain = 0.02F;  // of the sum of squares of a part that was left out
constexpr float kScatter = 2;        // standard errors that the gain must exceed
constexpr int kLeastParts = 3;
constexpr float kFarther = 0.5F;  // weight of a cell beside, along each axis

/// 0 to 5: the axis of the greatest component, and its sign.
int faceOf(const Vector3f& normal) {
  Eigen::Index axis = 0;
  normal.cwiseAbs().maxCoeff(&axis);
  return static_cast<int>(2 * axis) + (normal[axis] > 0 ? 1 : 0);
}

std::array<std::int32_t, 3> sheenCellOf(const Vector3f& point, float side) {
  std::array<std::int32_t, 3> cell{};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    cell[axis] = static_cast<std::int32_t>(std::floor(point[static_cast<Eigen::Index>(axis)] / side));
  }
  return cell;
}

Strengths strengthsOf(const AppearanceMoments& moments) {
  AppearanceMoments::Square matrix = moments.functions;
  matrix.diagonal().array() += kPrior * moments.weight + 1e-6F;  // functions that are not used have nothing else
  return matrix.ldlt().solve(moments.products);
}

/// How much of the squares of some moments strengths take away, and how far they should go: a, b of 2 a x - b x^2.
struct Gain {
  float along = 0, across = 0;
};
Gain gainOf(const Strengths& strengths, const AppearanceMoments& moments) {
  return {strengths.cwiseProduct(moments.products).sum(), strengths.cwiseProduct(moments.functions * strengths).sum()};
}

}  // namespace

void AppearanceMoments::add(const AppearanceMoments& more, float factor) {
  functions += factor * more.functions;
  products += factor * more.products;
  squares += factor * more.squares;
  weight += factor * more.weight;
}

std::uint64_t AppearanceCells::keyOf(const Index3& cell, int direction) {
  constexpr std::uint64_t kMask = (1U << 20U) - 1;
  std::uint64_t key = static_cast<std::uint64_t>(direction);
  for (const std::int32_t index : cell) key = key << 20U | (static_cast<std::uint64_t>(index) & kMask);
  return key;
}

const AppearanceCell* AppearanceCells::find(const Index3& cell, int direction) const {
  const auto found = index_.find(keyOf(cell, direction));
  return found == index_.end() ? nullptr : &cells_[found->second];
}

AppearanceMoments& AppearanceCells::momentsAt(const Vector3f& point, const Vector3f& normal) {
  const Place place{sheenCellOf(point, side_), faceOf(normal)};
  const auto [entry, is_new] =
      index_.emplace(keyOf(place.cell, place.direction), static_cast<std::uint32_t>(cells_.size()));
  if (is_new) {
    cells_.emplace_back();
    places_.push_back(place);
  }
  // Parts are apart from each other, so that errors that neighbours share do not prove each other.
  const Index3 fine = sheenCellOf(point, side_ / 4);
  const std::int32_t sum = fine[0] + 2 * fine[1] + 3 * fine[2];
  return cells_[entry->second].parts[static_cast<std::size_t>(sum & (AppearanceCell::kParts - 1))];
}

const AppearanceCell* AppearanceCells::cellAt(const Vector3f& point, const Vector3f& normal) const {
  return find(sheenCellOf(point, side_), faceOf(normal));
}

AppearanceCell AppearanceCells::solved(const AppearanceCell& own, const Index3& cell, int direction) const {
  AppearanceCell pooled = own;
  for (int step = 0; step < 27; ++step) {
    const Index3 beside = {cell[0] + step % 3 - 1, cell[1] + step / 3 % 3 - 1, cell[2] + step / 9 - 1};
    const AppearanceCell* other = step == 13 ? nullptr : find(beside, direction);
    if (other == nullptr) continue;
    const int steps = std::abs(step % 3 - 1) + std::abs(step / 3 % 3 - 1) + std::abs(step / 9 - 1);
    for (std::size_t part = 0; part < pooled.parts.size(); ++part) {
      pooled.parts[part].add(other->parts[part], std::pow(kFarther, static_cast<float>(steps)));
    }
  }
  AppearanceMoments all;
  for (const AppearanceMoments& part : pooled.parts) all.add(part, 1);

  Gain total;
  std::vector<float> gains;
  for (const AppearanceMoments& part : pooled.parts) {
    if (!(part.weight > 0) || !(part.squares > 0)) continue;
    AppearanceMoments others = all;
    others.add(part, -1);
    const Gain gain = gainOf(strengthsOf(others), part);
    total.along += gain.along;
    total.across += gain.across;
    gains.push_back((2 * gain.along - gain.across) / part.squares);
  }
  AppearanceCell result;
  result.parts = own.parts;
  if (all.weight > 0) result.noise = all.squares / (3 * all.weight);
  if (static_cast<int>(gains.size()) < kLeastParts) return result;
  const auto count = static_cast<float>(gains.size());
  const Eigen::Map<const Eigen::ArrayXf> each(gains.data(), static_cast<Eigen::Index>(gains.size()));
  const float error = std::sqrt((each - each.mean()).square().sum() / (count - 1) / count);
  if (!(each.mean() > std::max(kLeastGain, kScatter * error))) return result;
  // As far as what was left out would have gone.
  const float share = std::clamp(total.along / total.across, 0.F, 1.F);
  result.strengths = share * strengthsOf(all);
  const Gain gain = gainOf(result.strengths, all);
  result.noise = std::max(0.F, all.squares - 2 * gain.along + gain.across) / (3 * all.weight);
  result.is_proved = true;
  return result;
}

bool AppearanceCells::solve() {
  std::vector<AppearanceCell> results;
  results.reserve(cells_.size());
  for (std::size_t i = 0; i < cells_.size(); ++i) {
    results.push_back(solved(cells_[i], places_[i].cell, places_[i].direction));
  }
  cells_ = std::move(results);
  return std::any_of(cells_.begin(), cells_.end(), [](const AppearanceCell& cell) { return cell.is_proved; });
}

float AppearanceCells::usualNoise() const {
  std::vector<float> noises;
  for (const AppearanceCell& cell : cells_) noises.push_back(cell.noise);
  return median(std::move(noises));
}

AppearanceCells::Blend AppearanceCells::blendAt(const Vector3f& point, const Vector3f& normal) const {
  const Vector3f at = point / side_ - Vector3f::Constant(0.5F);  // in cells, from the centre of cell 0
  const Index3 low = sheenCellOf(at, 1);
  Blend blend;
  float total = 0;
  for (int corner = 0; corner < 8; ++corner) {
    Index3 cell = low;
    float weight = 1;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const bool is_high = (corner >> axis & 1) != 0;
      cell[axis] += is_high ? 1 : 0;
      const float share = at[static_cast<Eigen::Index>(axis)] - static_cast<float>(low[axis]);
      weight *= is_high ? share : 1 - share;
    }
    if (weight == 0) continue;
    for (Eigen::Index axis = 0; axis < 3; ++axis) {
      const AppearanceCell* found = find(cell, static_cast<int>(2 * axis) + (normal[axis] > 0 ? 1 : 0));
      if (found == nullptr) continue;
      const float share = weight * normal[axis] * normal[axis];
      total += share;
      if (!found->is_proved) continue;
      blend.strengths += share * found->strengths;
      blend.is_zero = false;
    }
  }
  if (!(total > 0) || blend.is_zero) return {};
  blend.strengths /= total;
  return blend;
}

}  // namespace cloud_colorizer
