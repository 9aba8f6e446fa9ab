// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause
#include "alignment/intensity.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace cloud_colorizer::alignment {
namespace {

constexpr int kBins = 16;
constexpr int kMinInBlock = 8;     // observations that make a local mean
constexpr float kClipLevels = 40;  // grey levels from the local mean: beyond is an outlier

using Vector6f = Eigen::Matrix<float, 6, 1>;

// Everything relative to the local mean; weight 0 where there is none.
struct Relative {
  std::vector<float> values, ranks, weights;
  std::vector<Vector6f> jacobians;
};

struct BlockMean {
  float value = 0, rank = 0, weight = 0;
  Vector6f jacobian = Vector6f::Zero();
  int count = 0;
};

void relateView(const Tracks& tracks, const ViewEquations& seen, const Eigen::VectorXf& ranks, std::size_t v,
                Relative& relative) {
  const Equations<6>& all = seen.equations;
  std::vector<BlockMean> means;
  for (std::uint32_t k = tracks.offsets[v]; k < tracks.offsets[v + 1]; ++k) {
    if (!(all.weights[k] > 0)) continue;
    if (seen.blocks[k] >= means.size()) means.resize(seen.blocks[k] + 1);
    BlockMean& mean = means[seen.blocks[k]];
    const float w = all.weights[k];
    mean.value += w * all.values[k];
    mean.rank += w * ranks[tracks.sights[k].point];
    mean.jacobian += w * all.jacobians[k];
    mean.weight += w;
    ++mean.count;
  }
  for (std::uint32_t k = tracks.offsets[v]; k < tracks.offsets[v + 1]; ++k) {
    if (!(all.weights[k] > 0)) continue;
    const BlockMean& mean = means[seen.blocks[k]];
    if (mean.count < kMinInBlock) continue;
    relative.values[k] = std::clamp(all.values[k] - mean.value / mean.weight, -kClipLevels, kClipLevels);
    relative.ranks[k] = ranks[tracks.sights[k].point] - mean.rank / mean.weight;
    relative.jacobians[k] = all.jacobians[k] - mean.jacobian / mean.weight;
    relative.weights[k] = all.weights[k];
  }
}

Relative relate(const Tracks& tracks, const ViewEquations& seen, const Eigen::VectorXf& ranks, const Workers& workers) {
  const std::size_t count = tracks.numObservations();
  Relative relative{std::vector<float>(count, 0), std::vector<float>(count, 0), std::vector<float>(count, 0),
                    std::vector<Vector6f>(count, Vector6f::Zero())};
  workers.forEach(tracks.numViews(), [&](std::size_t v) { relateView(tracks, seen, ranks, v, relative); });
  return relative;
}

// Upper bounds of bins of about equal count.
std::vector<float> binBounds(const Relative& relative) {
  std::vector<float> sorted;
  for (std::size_t k = 0; k < relative.weights.size(); ++k) {
    if (relative.weights[k] > 0) sorted.push_back(relative.ranks[k]);
  }
  std::sort(sorted.begin(), sorted.end());
  std::vector<float> bounds;
  for (int b = 1; b < kBins && !sorted.empty(); ++b) {
    bounds.push_back(sorted[sorted.size() * static_cast<std::size_t>(b) / kBins]);
  }
  return bounds;
}

struct BinMeans {
  std::vector<float> bounds;
  std::vector<double> means;
  double explained_sum = 0, total_sum = 0, weight = 0;

  double operator()(float rank) const {
    return means[static_cast<std::size_t>(std::upper_bound(bounds.begin(), bounds.end(), rank) - bounds.begin())];
  }
};

BinMeans explain(const Relative& relative) {
  BinMeans bins{binBounds(relative), std::vector<double>(kBins, 0), 0, 0, 0};
  std::vector<double> weights(kBins, 0);
  for (std::size_t k = 0; k < relative.weights.size(); ++k) {
    const double w = relative.weights[k];
    if (!(w > 0)) continue;
    const auto b = static_cast<std::size_t>(
        std::upper_bound(bins.bounds.begin(), bins.bounds.end(), relative.ranks[k]) - bins.bounds.begin());
    bins.means[b] += w * relative.values[k];
    weights[b] += w;
    bins.total_sum += w * relative.values[k] * relative.values[k];
    bins.weight += w;
  }
  for (std::size_t b = 0; b < kBins; ++b) {
    if (!(weights[b] > 0)) continue;
    bins.means[b] /= weights[b];
    bins.explained_sum += weights[b] * bins.means[b] * bins.means[b];
  }
  return bins;
}

}  // namespace

Eigen::VectorXf intensityRanks(const Eigen::VectorXf& intensity) {
  if (intensity.size() == 0) return {};
  const auto value = [&](Eigen::Index i) { return std::isnan(intensity[i]) ? -INFINITY : intensity[i]; };
  std::vector<Eigen::Index> order(static_cast<std::size_t>(intensity.size()));
  std::iota(order.begin(), order.end(), 0);
  std::stable_sort(order.begin(), order.end(), [&](auto a, auto b) { return value(a) < value(b); });
  if (value(order.front()) == value(order.back())) return {};
  Eigen::VectorXf ranks(intensity.size());
  const auto last = static_cast<float>(order.size() - 1);
  for (std::size_t begin = 0; begin < order.size();) {  // equal values share the middle rank
    std::size_t end = begin;
    while (end < order.size() && value(order[end]) == value(order[begin])) ++end;
    for (std::size_t i = begin; i < end; ++i) ranks[order[i]] = 0.5F * static_cast<float>(begin + end - 1) / last;
    begin = end;
  }
  return ranks;
}

IntensityTerm intensityTerm(const Tracks& tracks, const ViewEquations& seen, const Eigen::VectorXf& ranks,
                            const Workers& workers) {
  const std::size_t num_views = tracks.numViews();
  IntensityTerm term;
  term.hessians.assign(num_views, Eigen::Matrix<double, 6, 6>::Zero());
  term.gradients.assign(num_views, Twist::Zero());
  const Relative relative = relate(tracks, seen, ranks, workers);
  const BinMeans bins = explain(relative);
  if (!(bins.total_sum > 0)) return term;
  term.explained = bins.explained_sum / bins.total_sum;
  const double unexplained = std::max(1 - term.explained, 1e-3);
  const double noise2 = std::max(1.0, unexplained * bins.total_sum / bins.weight);  // grey levels squared
  term.cost = 0.5 * bins.weight * std::log(unexplained);
  const double factor = 1 / noise2, explained = term.explained;
  workers.forEach(num_views, [&](std::size_t v) {
    for (std::uint32_t k = tracks.offsets[v]; k < tracks.offsets[v + 1]; ++k) {
      const double w = factor * relative.weights[k];
      if (!(w > 0)) continue;
      const Twist jacobian = relative.jacobians[k].cast<double>();
      term.gradients[v] += w * (explained * relative.values[k] - bins(relative.ranks[k])) * jacobian;
      // Only the explained part of the grey level moves with the intensity.
      term.hessians[v] += (w * explained) * jacobian * jacobian.transpose();
    }
  });
  return term;
}

std::vector<float> unexplainedShares(const Tracks& tracks, const ViewEquations& seen, const Eigen::VectorXf& ranks,
                                     const std::vector<float>& learn, const Workers& workers) {
  std::vector<float> shares(tracks.numObservations(), std::nanf(""));
  Relative relative = relate(tracks, seen, ranks, workers);
  const std::vector<float> all = relative.weights;
  for (std::size_t k = 0; k < all.size(); ++k) {
    if (!(learn[k] > 0)) relative.weights[k] = 0;
  }
  const BinMeans bins = explain(relative);
  if (!(bins.total_sum > 0)) return shares;
  const double variance = bins.total_sum / bins.weight;
  for (std::size_t k = 0; k < all.size(); ++k) {
    if (!(all[k] > 0)) continue;
    const double predicted = bins(relative.ranks[k]);
    shares[k] = static_cast<float>(predicted * (predicted - 2 * relative.values[k]) / variance);
  }
  return shares;
}

}  // namespace cloud_colorizer::alignment
