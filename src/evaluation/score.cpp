// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause
#include "evaluation/score.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <numeric>

#include "cloud_colorizer/base/check.hpp"
#include "evaluation/neighbors.hpp"

namespace cloud_colorizer {
namespace {

constexpr double kRepThreshold = 20;
constexpr double kMaxPsnr = 99;

/// The columns of truth and result that are compared, clamped to the range of a colour.
struct Compared {
  Values truth, result;
};

Compared coloredOnly(ValuesRef truth, ValuesRef result, const std::vector<std::uint8_t>& colored) {
  require<std::invalid_argument>(truth.cols() == result.cols() &&
                                     static_cast<std::size_t>(truth.cols()) == colored.size() && truth.rows() == 3 &&
                                     result.rows() == 3,
                                 "truth of ", truth.rows(), " x ", truth.cols(), " and result of ", result.rows(),
                                 " x ", result.cols(), " must both be 3 x number of points");
  const auto count = static_cast<Eigen::Index>(colored.size()) - std::count(colored.begin(), colored.end(), 0);
  require<std::invalid_argument>(count > 0, "none of the ", colored.size(), " points is coloured");
  Compared compared{Values(3, count), Values(3, count)};
  Eigen::Index next = 0;
  for (Eigen::Index p = 0; p < truth.cols(); ++p) {
    if (colored[static_cast<std::size_t>(p)] == 0) continue;
    compared.truth.col(next) = truth.col(p).cwiseMax(0).cwiseMin(255);
    compared.result.col(next++) = result.col(p).cwiseMax(0).cwiseMin(255);
  }
  return compared;
}

double aepOf(const Compared& c) {
  return (c.truth - c.result).cast<double>().cwiseAbs().mean();
}

double repOf(const Compared& c) {
  const auto errors = (c.truth - c.result).cwiseAbs().colwise().mean();
  return (errors.array() > static_cast<float>(kRepThreshold)).cast<double>().mean();
}

double meanCiede2000(const Compared& c) {
  double sum = 0;
  for (Eigen::Index p = 0; p < c.truth.cols(); ++p) {
    sum += ciede2000(labFromRgb(c.truth.col(p).cast<double>()), labFromRgb(c.result.col(p).cast<double>()));
  }
  return sum / static_cast<double>(c.truth.cols());
}

}  // namespace

double bestGain(const std::vector<float>& truth, const std::vector<float>& values) {
  std::vector<std::pair<double, double>> ratios;  // (ratio, weight)
  double total = 0;
  for (std::size_t i = 0; i < values.size(); ++i) {
    if (!(values[i] > 0)) continue;
    ratios.emplace_back(static_cast<double>(truth[i]) / values[i], values[i]);
    total += values[i];
  }
  if (ratios.empty()) return 1;
  std::sort(ratios.begin(), ratios.end());
  double sum = 0;
  for (const auto& [ratio, weight] : ratios) {
    sum += weight;
    if (sum >= total / 2) return ratio;
  }
  return ratios.back().first;
}

Score scoreColors(ValuesRef truth, ValuesRef result, const std::vector<std::uint8_t>& colored) {
  Compared compared = coloredOnly(truth, result, colored);
  Score score;
  score.num_points = static_cast<std::size_t>(compared.truth.cols());
  score.coverage = static_cast<double>(score.num_points) / static_cast<double>(colored.size());
  score.aep = aepOf(compared);
  score.rep = repOf(compared);
  const double mse =
      (compared.truth - compared.result).cast<double>().squaredNorm() / static_cast<double>(compared.truth.size());
  score.psnr = mse > 0 ? std::min(kMaxPsnr, 10 * std::log10(255 * 255 / mse)) : kMaxPsnr;
  score.ciede2000 = meanCiede2000(compared);
  for (int c = 0; c < 3; ++c) {
    std::vector<float> t(score.num_points), r(score.num_points);
    for (std::size_t p = 0; p < t.size(); ++p) {
      t[p] = compared.truth(c, static_cast<Eigen::Index>(p));
      r[p] = compared.result(c, static_cast<Eigen::Index>(p));
    }
    score.gain[c] = bestGain(t, r);
    compared.result.row(c) = (compared.result.row(c) * static_cast<float>(score.gain[c])).cwiseMin(255);
  }
  score.aep_gain = aepOf(compared);
  score.rep_gain = repOf(compared);
  return score;
}

Score scoreClouds(const Points& truth_points, ValuesRef truth, const Points& points, ValuesRef result,
                  double max_distance) {
  require<std::invalid_argument>(max_distance > 0, "the largest distance between compared points must be positive, is ",
                                 max_distance, " m");
  const auto nearest = nearestNeighbors(points, truth_points);
  Values matched = Values::Zero(3, truth_points.cols());
  std::vector<std::uint8_t> colored(static_cast<std::size_t>(truth_points.cols()), 0);
  double smallest = std::numeric_limits<double>::infinity();
  for (std::size_t p = 0; p < nearest.size(); ++p) {
    smallest = std::min<double>(smallest, nearest[p].distance);
    if (nearest[p].distance > max_distance) continue;
    colored[p] = 1;
    matched.col(static_cast<Eigen::Index>(p)) = result.col(nearest[p].index);
  }
  require(std::count(colored.begin(), colored.end(), 1) > 0, "the clouds do not overlap: the nearest pair of the ",
          truth_points.cols(), " and ", points.cols(), " points is ", smallest, " m apart, more than the allowed ",
          max_distance, " m; check that both are in the same frame, or allow more");
  return scoreColors(truth, matched, colored);
}

std::string Score::describe() const {
  char text[256];
  std::snprintf(text, sizeof text,
                "%zu points (coverage %.2f %%): AEP %.3f, REP %.4f, PSNR %.2f dB, CIEDE2000 %.3f; after one gain per "
                "channel (%.3f, %.3f, %.3f): AEP %.3f, REP %.4f",
                num_points, 100 * coverage, aep, rep, psnr, ciede2000, gain[0], gain[1], gain[2], aep_gain, rep_gain);
  return text;
}

}  // namespace cloud_colorizer
