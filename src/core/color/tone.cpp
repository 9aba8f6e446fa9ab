// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause
#include "cloud_colorizer/color/tone.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "cloud_colorizer/base/check.hpp"

namespace cloud_colorizer {
namespace {

constexpr std::array<double, 5> kBlur = {1, 4, 6, 4, 1};

/// Every sample counts in the cells around its own as well.
ToneCells blurred(const ToneCells& samples) {
  ToneCells blurred;
  for (const auto& [cell, sum] : samples) {
    for (std::int32_t x = 0; x < 5; ++x)
      for (std::int32_t y = 0; y < 5; ++y)
        for (std::int32_t z = 0; z < 5; ++z) {
          const double weight = kBlur[static_cast<std::size_t>(x)] * kBlur[static_cast<std::size_t>(y)] *
                                kBlur[static_cast<std::size_t>(z)];
          ToneSum& at = blurred[{cell[0] + x - 2, cell[1] + y - 2, cell[2] + z - 2}];
          at.log_gain += weight * sum.log_gain;
          at.count += weight * sum.count;
        }
  }
  return blurred;
}

/// The cells whose centres surround some points, as one grid.
class CellGrid {
 public:
  CellGrid(PointsRef points, double cell, const std::map<ToneCell, float>& log_factors) : scale_(1 / cell) {
    const Eigen::Array3d low = points.rowwise().minCoeff().cast<double>();
    const Eigen::Array3d high = points.rowwise().maxCoeff().cast<double>();
    low_ = (low * scale_ - 0.5).floor();
    size_ = ((high * scale_ - 0.5).floor() - low_).cast<std::ptrdiff_t>() + 2;
    values_.assign(static_cast<std::size_t>(size_.prod()), std::numeric_limits<float>::quiet_NaN());
    for (std::ptrdiff_t x = 0; x < size_[0]; ++x)
      for (std::ptrdiff_t y = 0; y < size_[1]; ++y)
        for (std::ptrdiff_t z = 0; z < size_[2]; ++z) {
          const auto found = log_factors.find({index(0, x), index(1, y), index(2, z)});
          if (found != log_factors.end()) values_[at(x, y, z)] = found->second;
        }
  }

  /// Trilinear among the cells that have a value; 0 where none has.
  float logFactorAt(const Eigen::Vector3f& place) const {
    const Eigen::Array3d position = place.array().cast<double>() * scale_ - 0.5 - low_;
    const Eigen::Array3d base = position.floor(), part = position - base;
    double sum = 0, weights = 0;
    for (int corner = 0; corner < 8; ++corner) {
      double weight = 1;
      std::array<std::ptrdiff_t, 3> cell{};
      for (int axis = 0; axis < 3; ++axis) {
        const bool upper = (corner >> axis & 1) != 0;
        weight *= upper ? part[axis] : 1 - part[axis];
        cell[static_cast<std::size_t>(axis)] = static_cast<std::ptrdiff_t>(base[axis]) + (upper ? 1 : 0);
      }
      const float value = values_[at(cell[0], cell[1], cell[2])];
      if (std::isnan(value)) continue;
      sum += weight * static_cast<double>(value);
      weights += weight;
    }
    return weights > 0 ? static_cast<float>(sum / weights) : 0;
  }

 private:
  std::int32_t index(int axis, std::ptrdiff_t offset) const {
    return static_cast<std::int32_t>(low_[axis]) + static_cast<std::int32_t>(offset);
  }
  std::size_t at(std::ptrdiff_t x, std::ptrdiff_t y, std::ptrdiff_t z) const {
    return static_cast<std::size_t>((x * size_[1] + y) * size_[2] + z);
  }

  double scale_;
  Eigen::Array3d low_;  ///< index of the first cell
  Eigen::Array<std::ptrdiff_t, 3, 1> size_;
  std::vector<float> values_;
};

}  // namespace

void ToneParams::check() const {
  requireInRange("exposure_range", exposure_range, 1.0, 1e6);
}

ToneCell ToneField::cellOf(const Eigen::Vector3f& place, double cell) {
  const Eigen::Array3d index = (place.array().cast<double>() / cell).floor();
  return {static_cast<std::int32_t>(index[0]), static_cast<std::int32_t>(index[1]),
          static_cast<std::int32_t>(index[2])};
}

ToneField::ToneField(const ToneCells& samples, double cell, const ToneParams& params) : cell_(cell) {
  params.check();
  requireInRange("the cells of tones", cell, 1e-9, 1e9);
  const double limit = std::log(params.exposure_range);
  for (const auto& [index, sum] : blurred(samples)) {
    require<std::invalid_argument>(std::isfinite(sum.log_gain) && sum.count > 0, "tone: samples of cell (", index[0],
                                   ", ", index[1], ", ", index[2], ") are not finite");
    const double log_gain = sum.log_gain / sum.count, excess = std::max(0.0, std::abs(log_gain) - limit);
    log_factors_[index] = static_cast<float>(log_gain > 0 ? -excess : excess);
  }
}

void ToneField::apply(PointsRef points, Values& values) const {
  if (log_factors_.empty() || points.cols() == 0) return;
  const CellGrid block(points, cell_, log_factors_);
  for (Eigen::Index i = 0; i < points.cols(); ++i) values.col(i) *= std::exp(block.logFactorAt(points.col(i)));
}

}  // namespace cloud_colorizer
