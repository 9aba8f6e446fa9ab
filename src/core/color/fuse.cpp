// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause
#include "cloud_colorizer/color/fuse.hpp"

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "base/robust.hpp"
#include "cloud_colorizer/base/check.hpp"

namespace cloud_colorizer {
namespace {

using Eigen::Index;
using WeightedValues = std::vector<std::pair<float, float>>;  // (value, weight)

constexpr float kTukey = 4.685F;  // 95 % efficient on normal errors
constexpr int kRobustRounds = 4;

/// The observations of one point, and a weight for each.
struct PointViews {
  const Values& values;
  Index begin;
  const std::vector<float>& weights;

  Index size() const { return static_cast<Index>(weights.size()); }
  float value(Index channel, Index view) const { return values(channel, begin + view); }
  float weight(Index view) const { return weights[static_cast<std::size_t>(view)]; }
};

float weightedMean(const PointViews& views, Index channel) {
  double sum = 0, total = 0;
  for (Index i = 0; i < views.size(); ++i) {
    sum += static_cast<double>(views.weight(i)) * views.value(channel, i);
    total += views.weight(i);
  }
  return static_cast<float>(sum / total);
}

float meanStddev(const PointViews& views) {
  const Index channels = views.values.rows();
  if (views.size() < 2 || channels == 0) return 0;
  double stddev = 0;
  for (Index c = 0; c < channels; ++c) {
    const double mean = weightedMean(views, c);
    double squares = 0, total = 0;
    for (Index i = 0; i < views.size(); ++i) {
      const double difference = views.value(c, i) - mean;
      squares += views.weight(i) * difference * difference;
      total += views.weight(i);
    }
    stddev += std::sqrt(squares / total);
  }
  return static_cast<float>(stddev / static_cast<double>(channels));
}

/// Sorts `values`. With equal weights it is the ordinary median: between two middle values, their mean.
float weightedMedian(WeightedValues& values) {
  std::sort(values.begin(), values.end());
  double total = 0;
  for (const auto& value : values) total += value.second;
  double below = 0;
  for (std::size_t i = 0; i < values.size(); ++i) {
    below += values[i].second;
    if (2 * below > total) return values[i].first;
    if (2 * below == total && i + 1 < values.size()) return 0.5F * (values[i].first + values[i + 1].first);
  }
  return values.back().first;
}

float channelMedian(const PointViews& views, Index channel, WeightedValues& scratch) {
  scratch.clear();
  for (Index i = 0; i < views.size(); ++i) {
    if (views.weight(i) > 0) scratch.emplace_back(views.value(channel, i), views.weight(i));
  }
  return weightedMedian(scratch);
}

/// Calls fuse(p, begin, weights) for every point that is seen; it writes values.col(p) and may change the weights,
/// which come as all ones.
template <class Fuse>
Fused fuseEach(const Observations& observations, const Fuse& fuse) {
  checkObservations(observations);
  const auto num_points = static_cast<Index>(observations.numPoints());
  Fused fused;
  fused.values.setZero(observations.values.rows(), num_points);
  fused.count.setZero(num_points);
  fused.stddev.setZero(num_points);
  std::vector<float> weights;
  for (Index p = 0; p < num_points; ++p) {
    const std::uint32_t begin = observations.offsets[p], count = observations.offsets[p + 1] - begin;
    fused.count(p) = static_cast<int>(count);
    if (count == 0) continue;
    weights.assign(count, 1.0F);
    fuse(fused, p, begin, weights);
    fused.stddev(p) = meanStddev({observations.values, begin, weights});
  }
  return fused;
}

/// The Tukey weights of one point. The scratch memory is kept from point to point.
class RobustWeights {
 public:
  explicit RobustWeights(float min_scale) : min_scale_(min_scale) {}

  /// `weights`: in, the prior weights, not all zero; out, the final ones.
  void operator()(const Values& values, Index begin, std::vector<float>& weights) {
    prior_ = weights;
    const PointViews views{values, begin, weights};
    center_.resize(static_cast<std::size_t>(values.rows()));
    for (Index c = 0; c < values.rows(); ++c) center_[c] = channelMedian(views, c, scratch_);
    computeResiduals(views);
    const float limit = kTukey * std::max(min_scale_, static_cast<float>(kMadToSigma) * medianResidual());
    for (int round = 0; round < kRobustRounds; ++round) {
      if (!reweigh(limit, weights)) return;
      for (Index c = 0; c < values.rows(); ++c) center_[c] = weightedMean(views, c);
      computeResiduals(views);
    }
  }

 private:
  void computeResiduals(const PointViews& views) {
    const Index channels = views.values.rows();
    residuals_.assign(prior_.size(), 0.0F);
    for (Index i = 0; i < views.size(); ++i) {
      float squares = 0;
      for (Index c = 0; c < channels; ++c) {
        const float difference = views.value(c, i) - center_[c];
        squares += difference * difference;
      }
      residuals_[i] = channels > 0 ? std::sqrt(squares / static_cast<float>(channels)) : 0.0F;
    }
  }

  float medianResidual() {
    scratch_.clear();
    for (std::size_t i = 0; i < prior_.size(); ++i) {
      if (prior_[i] > 0) scratch_.emplace_back(residuals_[i], prior_[i]);
    }
    return weightedMedian(scratch_);
  }

  /// False, and `weights` as they were, if none would be left.
  bool reweigh(float limit, std::vector<float>& weights) {
    candidate_.resize(prior_.size());
    float total = 0;
    for (std::size_t i = 0; i < prior_.size(); ++i) {
      const float ratio = residuals_[i] / limit, inside = std::max(0.0F, 1 - ratio * ratio);
      candidate_[i] = prior_[i] * inside * inside;
      total += candidate_[i];
    }
    if (!(total > 0)) return false;
    weights.swap(candidate_);
    return true;
  }

  float min_scale_;
  std::vector<float> prior_, center_, residuals_, candidate_;
  WeightedValues scratch_;
};

/// Observation weights of one point; all ones where they are all zero.
void priorWeights(const std::vector<float>& all, std::uint32_t begin, std::vector<float>& weights) {
  float total = 0;
  for (std::size_t i = 0; i < weights.size(); ++i) total += all[begin + i];
  if (!(total > 0)) return;
  std::copy_n(all.begin() + begin, weights.size(), weights.begin());
}

}  // namespace

void checkObservations(const Observations& observations) {
  const std::size_t count = observations.numObservations();
  const auto bad = [](bool ok, auto... what) { require<std::invalid_argument>(ok, "observations: ", what...); };
  bad(observations.distances.size() == count && observations.weights.size() == count &&
          static_cast<std::size_t>(observations.values.cols()) == count,
      count, " views, ", observations.distances.size(), " distances, ", observations.weights.size(), " weights and ",
      observations.values.cols(), " columns of values must be equally many");
  const auto& offsets = observations.offsets;
  bad(offsets.empty() ? count == 0 : offsets.front() == 0 && offsets.back() == count, "offsets must lead from 0 to ",
      count);
  bad(std::is_sorted(offsets.begin(), offsets.end()), "offsets must ascend");
  bad(observations.values.size() == 0 || observations.values.allFinite(), "all values must be finite");
  bad(std::all_of(observations.weights.begin(), observations.weights.end(), [](float w) { return w >= 0 && w <= 1; }),
      "all weights must lie in [0, 1]");
}

Fused fuseClosest(const Observations& observations) {
  const auto& distances = observations.distances;
  return fuseEach(observations, [&](Fused& fused, Index p, std::uint32_t begin, std::vector<float>& weights) {
    const auto first = distances.begin() + begin;
    const auto nearest = std::min_element(first, first + static_cast<std::ptrdiff_t>(weights.size()));
    fused.values.col(p) = observations.values.col(nearest - distances.begin());
  });
}

Fused fuseMean(const Observations& observations) {
  return fuseEach(observations, [&](Fused& fused, Index p, std::uint32_t begin, std::vector<float>& weights) {
    const PointViews views{observations.values, begin, weights};
    for (Index c = 0; c < fused.values.rows(); ++c) fused.values(c, p) = weightedMean(views, c);
  });
}

Fused fuseMedian(const Observations& observations) {
  WeightedValues scratch;
  return fuseEach(observations, [&](Fused& fused, Index p, std::uint32_t begin, std::vector<float>& weights) {
    const PointViews views{observations.values, begin, weights};
    for (Index c = 0; c < fused.values.rows(); ++c) fused.values(c, p) = channelMedian(views, c, scratch);
  });
}

Fused fuseRobust(const Observations& observations, float min_scale) {
  require<std::invalid_argument>(std::isfinite(min_scale) && min_scale > 0, "min_scale = ", min_scale,
                                 " must be greater than 0");
  RobustWeights robust(min_scale);
  Eigen::VectorXf final_weights(static_cast<Index>(observations.numObservations()));
  Fused result = fuseEach(observations, [&](Fused& fused, Index p, std::uint32_t begin, std::vector<float>& weights) {
    priorWeights(observations.weights, begin, weights);
    if (weights.size() > 2) robust(observations.values, begin, weights);
    const PointViews views{observations.values, begin, weights};
    for (Index c = 0; c < fused.values.rows(); ++c) fused.values(c, p) = weightedMean(views, c);
    std::copy(weights.begin(), weights.end(), final_weights.data() + begin);
  });
  result.observation_weights = std::move(final_weights);
  return result;
}

}  // namespace cloud_colorizer
