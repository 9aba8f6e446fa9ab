// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause
#include "color/quantity.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace cloud_colorizer {
namespace {

using Eigen::Index;

constexpr Index kFields = 2;  // a value or class, and how well it is known

/// The values of which all but a hundredth are greater, and smaller.
std::pair<float, float> rangeOf(const Values& values) {
  constexpr double kOutside = 0.01;
  std::vector<float> all(values.data(), values.data() + values.size());
  const auto at = [&](double share) {
    const auto nth = all.begin() + static_cast<std::ptrdiff_t>(share * static_cast<double>(all.size() - 1));
    std::nth_element(all.begin(), nth, all.end());
    return *nth;
  };
  const float low = at(kOutside);
  return {low, at(1 - kOutside)};
}

Values fuseRadiometric(PointsRef points, Observations observations, const ZOrderGrid& grid, Method method,
                       const GraphParams& graph, const SystemParams& system) {
  Values fields = Values::Zero(kFields, points.cols());
  if (observations.numObservations() == 0) return fields;
  constexpr float kWhite = 255;
  const auto [low, high] = rangeOf(observations.values);
  const float scale = high > low ? kWhite / (high - low) : 1;
  observations.values = (observations.values.array() - low) * scale;
  const Fused fused = colorPoints(points, std::move(observations), grid, method, graph, system);
  for (Index p = 0; p < points.cols(); ++p) {
    if (fused.count[p] == 0) continue;
    fields(0, p) = low + fused.values(0, p) / scale;
    fields(1, p) = static_cast<float>(fused.count[p]);
  }
  return fields;
}

/// Of the views of one point.
class Votes {
 public:
  void add(float label, float weight) {
    const auto found =
        std::find_if(votes_.begin(), votes_.end(), [&](const auto& vote) { return vote.first == label; });
    if (found == votes_.end()) {
      votes_.emplace_back(label, weight);
    } else {
      found->second += weight;
    }
    total_ += weight;
  }

  /// The class and its share.
  std::pair<float, float> winner() const {
    const auto most = std::min_element(votes_.begin(), votes_.end(), [](const auto& a, const auto& b) {
      return a.second != b.second ? a.second > b.second : a.first < b.first;
    });
    return {most->first, most->second / total_};
  }

  void clear() {
    votes_.clear();
    total_ = 0;
  }

 private:
  std::vector<std::pair<float, float>> votes_;
  float total_ = 0;
};

/// A view that hardly counts still counts where it is the only one.
float weightOf(const Observations& observations, std::uint32_t k) {
  return std::max(observations.weights[k], std::numeric_limits<float>::min());
}

Values fuseLabels(const Observations& observations) {
  Values fields = Values::Zero(kFields, static_cast<Index>(observations.numPoints()));
  Votes votes;
  for (std::size_t p = 0; p < observations.numPoints(); ++p) {
    const std::uint32_t first = observations.offsets[p], last = observations.offsets[p + 1];
    if (first == last) continue;
    votes.clear();
    for (std::uint32_t k = first; k < last; ++k) votes.add(observations.values(0, k), weightOf(observations, k));
    const auto [label, share] = votes.winner();
    fields.col(static_cast<Index>(p)) << label, share;
  }
  return fields;
}

Values fuseLogits(const Observations& observations) {
  Values fields = Values::Zero(kFields, static_cast<Index>(observations.numPoints()));
  Eigen::ArrayXf sum(observations.values.rows());
  for (std::size_t p = 0; p < observations.numPoints(); ++p) {
    const std::uint32_t first = observations.offsets[p], last = observations.offsets[p + 1];
    if (first == last) continue;
    sum.setZero();
    float best = 0;
    for (std::uint32_t k = first; k < last; ++k) best = std::max(best, weightOf(observations, k));
    for (std::uint32_t k = first; k < last; ++k) {
      const auto scores = observations.values.col(k).array();
      const float most = scores.maxCoeff();
      sum += weightOf(observations, k) / best * (scores - (most + std::log((scores - most).exp().sum())));
    }
    Index label = 0;
    const float most = sum.maxCoeff(&label);
    fields.col(static_cast<Index>(p)) << static_cast<float>(label), 1 / (sum - most).exp().sum();
  }
  return fields;
}

}  // namespace

std::vector<Field> fieldsOf(const Quantity& quantity) {
  if (quantity.kind == ImageKind::kRadiometric) {
    return {{quantity.name, FieldType::kFloat32, 1}, {quantity.name + "_views", FieldType::kUint16, 1}};
  }
  return {{quantity.name, FieldType::kUint16, 1}, {quantity.name + "_confidence", FieldType::kFloat32, 1}};
}

std::size_t pointsAtATime(const Quantity& quantity, int channels) {
  constexpr std::size_t kNumbers = 600000;                                                       // a view
  if (quantity.kind == ImageKind::kRadiometric) return std::numeric_limits<std::size_t>::max();  // a graph over all
  return kNumbers / static_cast<std::size_t>(std::max(1, channels)) + 1;
}

Values fuseQuantity(PointsRef points, Observations observations, const ZOrderGrid& grid, ImageKind kind, Method method,
                    const GraphParams& graph, const SystemParams& system) {
  if (kind == ImageKind::kRadiometric) {
    return fuseRadiometric(points, std::move(observations), grid, method, graph, system);
  }
  checkObservations(observations);
  return kind == ImageKind::kLabels ? fuseLabels(observations) : fuseLogits(observations);
}

}  // namespace cloud_colorizer
