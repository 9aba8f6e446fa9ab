// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause
#include "cloud_colorizer/color/tone.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "cloud_colorizer/base/check.hpp"

namespace cloud_colorizer {
namespace {

constexpr std::array<double, 5> kBlur = {1, 4, 6, 4, 1};
/// How much what one view shows should have one factor, against that factor being the view's own exposure. Held-out
/// error on kitti_0005 and seven_scenes as it is | after one gain a view: 0: 17.1, 22.9 | 15.7, 20.3; 1: 17.7, 22.9 |
/// 15.6, 19.6; 4: 19.5, 23.3 | 15.3, 18.9; 10: 22.4, 24.1 | 15.0, 18.3; plain means: 18.0, 23.3 | 16.6, 21.4.
constexpr double kEvenness = 1;
constexpr int kRounds = 30;         // each leaves half of the error
constexpr double kHighest = 255;    // of 8 bits
constexpr double kKnee = 0.8;       // of the highest: what is brighter is compressed where the range asks for it
constexpr double kOutliers = 1e-3;  // of a cell's points, that may be brighter than its peak

/// What each cell is multiplied by, as a logarithm: least squares of what the points in each view differ by, from the
/// view's own exposure, and, kEvenness times, from their mean in that view. Alternately the means and the cells.
std::vector<double> solveTone(const ToneCells& cells, const std::vector<float>& log_gains) {
  std::vector<double> factors(cells.size(), 0), counts(log_gains.size(), 0);
  for (const auto& [at, cell] : cells)
    for (const auto& [view, count] : cell.views) counts[view] += count;
  for (int round = 0; round < kRounds; ++round) {
    std::vector<double> means(log_gains.size(), 0);
    std::size_t c = 0;
    for (const auto& [at, cell] : cells) {
      for (const auto& [view, count] : cell.views) means[view] += count * factors[c] / counts[view];
      ++c;
    }
    c = 0;
    for (const auto& [at, cell] : cells) {
      double sum = 0, all = 0;
      for (const auto& [view, count] : cell.views) {
        sum += count * (kEvenness * means[view] - static_cast<double>(log_gains[view]));
        all += count;
      }
      factors[c++] = sum / ((1 + kEvenness) * all);
    }
  }
  return factors;
}

/// Values of cells.
struct WeightedFactor {
  double sum = 0, weight = 0;
};
using CellFactors = std::map<ToneCell, WeightedFactor>;

/// Every cell counts in those around it as well. One axis after the other.
CellFactors blurred(CellFactors field) {
  for (std::size_t axis = 0; axis < 3; ++axis) {
    CellFactors wider;
    for (const auto& [cell, value] : field) {
      for (std::size_t k = 0; k < kBlur.size(); ++k) {
        ToneCell beside = cell;
        beside[axis] += static_cast<std::int32_t>(k) - 2;
        WeightedFactor& at = wider[beside];
        at.sum += kBlur[k] * value.sum;
        at.weight += kBlur[k] * value.weight;
      }
    }
    field = std::move(wider);
  }
  return field;
}

/// Up to the knee as it is, above so that `peak` becomes the highest (the extended operator of Reinhard et al., 2002).
double compressed(double value, double peak) {
  constexpr double kStart = kKnee * kHighest, kRange = kHighest - kStart;
  if (!(peak > kHighest) || value <= kStart) return value;
  const double above = (value - kStart) / kRange, most = (peak - kStart) / kRange;
  return kStart + kRange * above * (1 + above / (most * most)) / (1 + above);
}

ToneCell cellOf(const Eigen::Vector3f& place, double cell) {
  const Eigen::Array3d index = (place.array().cast<double>() / cell).floor();
  return {static_cast<std::int32_t>(index[0]), static_cast<std::int32_t>(index[1]),
          static_cast<std::int32_t>(index[2])};
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

ToneCells countViews(PointsRef points, const std::vector<Eigen::Index>& columns, const Observations& seen,
                     double cell) {
  ToneCells cells;
  for (const Eigen::Index i : columns) {
    const std::uint32_t begin = seen.offsets[static_cast<std::size_t>(i)],
                        end = seen.offsets[static_cast<std::size_t>(i) + 1];
    double weights = 0;
    for (std::uint32_t k = begin; k < end; ++k) weights += static_cast<double>(seen.weights[k]);
    if (!(weights > 0)) continue;
    auto& views = cells[cellOf(points.col(i), cell)].views;
    for (std::uint32_t k = begin; k < end; ++k) views[seen.views[k]] += static_cast<double>(seen.weights[k]) / weights;
  }
  return cells;
}

void addPeaks(PointsRef points, const Values& radiance, double cell, ToneCells& cells) {
  std::map<ToneCell, std::vector<float>> highest;
  for (Eigen::Index i = 0; i < points.cols(); ++i) {
    highest[cellOf(points.col(i), cell)].push_back(radiance.col(i).maxCoeff());
  }
  for (auto& [at, sum] : cells) {
    std::vector<float>& values = highest[at];
    const auto last = static_cast<double>(values.size() - 1);
    const auto peak = values.begin() + static_cast<std::ptrdiff_t>(std::ceil(last * (1 - kOutliers)));
    std::nth_element(values.begin(), peak, values.end());
    sum.peak = static_cast<double>(*peak);
  }
}

void addCells(const ToneCells& more, ToneCells& cells) {
  for (const auto& [at, sum] : more) {
    ToneSum& all = cells[at];
    for (const auto& [view, count] : sum.views) all.views[view] += count;
    all.peak = std::max(all.peak, sum.peak);
  }
}

ToneField::ToneField(const ToneCells& cells, const std::vector<float>& log_gains, double cell, Tone tone)
    : cell_(cell) {
  requireInRange("the cells of tones", cell, 1e-9, 1e9);
  for (const auto& [at, sum] : cells) {
    require<std::invalid_argument>(
        std::isfinite(sum.peak) && !sum.views.empty() && sum.views.rbegin()->first < log_gains.size(), "tone: cell (",
        at[0], ", ", at[1], ", ", at[2], ") has no views that there are");
  }
  const auto isOne = [](float log_gain) { return log_gain == 0; };
  if (tone == Tone::kDisplay && !std::all_of(log_gains.begin(), log_gains.end(), isOne)) {
    const std::vector<double> solved = solveTone(cells, log_gains);
    CellFactors field;
    std::size_t c = 0;
    for (const auto& [at, sum] : cells) {
      double weight = 0;
      for (const auto& [view, count] : sum.views) weight += count;
      field[at] = {weight * solved[c++], weight};
    }
    for (const auto& [at, value] : blurred(std::move(field))) {
      log_factors_[at] = static_cast<float>(value.sum / value.weight);
    }
  }
  for (const auto& [at, sum] : cells) {
    const auto factor = log_factors_.find(at);
    peak_ =
        std::max(peak_, sum.peak * (factor == log_factors_.end() ? 1 : std::exp(static_cast<double>(factor->second))));
  }
}

Eigen::RowVectorXf ToneField::factors(PointsRef points, const Values& radiance) const {
  Eigen::RowVectorXf factors = Eigen::RowVectorXf::Ones(points.cols());
  if (points.cols() == 0) return factors;
  if (!log_factors_.empty()) {
    const CellGrid block(points, cell_, log_factors_);
    for (Eigen::Index i = 0; i < points.cols(); ++i) factors[i] = std::exp(block.logFactorAt(points.col(i)));
  }
  for (Eigen::Index i = 0; i < points.cols(); ++i) {
    const double highest = static_cast<double>(radiance.col(i).maxCoeff() * factors[i]);
    if (highest > 0) factors[i] *= static_cast<float>(compressed(highest, peak_) / highest);
  }
  return factors;
}

}  // namespace cloud_colorizer
