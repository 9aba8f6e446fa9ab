// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause
#include "evaluation/heldout_errors.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "base/columns.hpp"
#include "base/robust.hpp"
#include "base/text.hpp"
#include "cloud_colorizer/surface/zorder.hpp"
#include "evaluation/score.hpp"
#include "evaluation/table.hpp"

namespace cloud_colorizer {
namespace {

using Eigen::Index;

std::string meanOf(const std::vector<float>& values) {
  return formatNumber(std::accumulate(values.begin(), values.end(), 0.0) / static_cast<double>(values.size()), 3);
}

std::string medianOf(const std::vector<float>& values) {
  return values.empty() ? "-" : formatNumber(static_cast<double>(median(values)), 3);
}

/// Steps between neighbours that the image does not have: mean |(c_p - c_q) - (v_p - v_q)| over pairs of points next
/// to each other on the surface.
void addSeams(const ColoredMap& map, const SeenImage& seen, const Values& predicted,
              const std::vector<std::uint8_t>& moved, const std::vector<Edge>& neighbors, HeldoutErrors& errors) {
  std::vector<std::int32_t> at(map.colored.size(), -1);
  for (std::size_t k = 0; k < seen.points.size(); ++k) {
    const auto point = static_cast<std::size_t>(seen.points[k]);
    if (map.colored[point] != 0 && moved[k] == 0) at[point] = static_cast<std::int32_t>(k);
  }
  for (const Edge& edge : neighbors) {
    const std::int32_t p = at[edge.p], q = at[edge.q];
    if (p < 0 || q < 0) continue;
    const Eigen::Vector3f step = predicted.col(p) - predicted.col(q) - seen.values.col(p) + seen.values.col(q);
    errors.seam += step.cwiseAbs().mean();
    ++errors.seam_pairs;
  }
}

}  // namespace

void HeldoutErrors::add(const HeldoutErrors& other) {
  for (const auto list :
       {&HeldoutErrors::raw, &HeldoutErrors::after_gain, &HeldoutErrors::given, &HeldoutErrors::trimmed,
        &HeldoutErrors::refined, &HeldoutErrors::shifts, &HeldoutErrors::warps, &HeldoutErrors::shift_errors}) {
    (this->*list).insert((this->*list).end(), (other.*list).begin(), (other.*list).end());
  }
  squares += other.squares;
  visible += other.visible;
  colored += other.colored;
  moved += other.moved;
  measured += other.measured;
  measured_colored += other.measured_colored;
  seam += other.seam;
  seam_pairs += other.seam_pairs;
}

void HeldoutErrors::countMeasured(const ColoredMap& map, const std::vector<Index>& at) {
  measured += at.size();
  for (const Index p : at) measured_colored += map.colored[static_cast<std::size_t>(p)];
}

std::vector<std::string> HeldoutErrors::header() {
  return splitAt(
      "method,points,mean,median,mean_with_gain,median_with_gain,mean_given_pose,mean_trimmed,mean_refined_pose,"
      "median_refined_pose,psnr,coverage,seam_step,moved_percent,visible_recall,"
      "shift_px,warp_px,shift_error_px",
      ',');
}

std::vector<std::string> HeldoutErrors::cells(const std::string& method) const {
  const auto share = [](std::size_t part, std::size_t whole) {
    return whole == 0 ? std::nan("") : static_cast<double>(part) / static_cast<double>(whole);
  };
  const double mse = colored == 0 ? std::nan("") : squares / (3.0 * static_cast<double>(colored));
  return {method,
          std::to_string(colored),
          meanOf(raw),
          medianOf(raw),
          meanOf(after_gain),
          medianOf(after_gain),
          meanOf(given),
          meanOf(trimmed),
          meanOf(refined),
          medianOf(refined),
          formatNumber(10 * std::log10(255 * 255 / mse), 2),
          formatNumber(share(colored, visible), 4),
          formatNumber(seam / static_cast<double>(seam_pairs), 3),
          formatNumber(100 * share(moved, colored), 2),
          measured == 0 ? "-" : formatNumber(share(measured_colored, measured), 4),
          medianOf(shifts),
          medianOf(warps),
          medianOf(shift_errors)};
}

Values predict(const ColoredMap& map, const SeenImage& seen, bool with_gain) {
  Values predicted = gatherColumns(map.colors, seen.points);
  if (!with_gain) return predicted;
  for (int c = 0; c < 3; ++c) {
    std::vector<float> image, colors;
    for (std::size_t k = 0; k < seen.points.size(); ++k) {
      if (map.colored[static_cast<std::size_t>(seen.points[k])] == 0) continue;
      image.push_back(seen.values(c, static_cast<Index>(k)));
      colors.push_back(predicted(c, static_cast<Index>(k)));
    }
    predicted.row(c) *= static_cast<float>(bestGain(image, colors));
  }
  return predicted.cwiseMin(255);
}

std::vector<std::uint8_t> movedPoints(const ColoredMap& median, const SeenImage& seen, double threshold) {
  const Values predicted = predict(median, seen, true);
  std::vector<std::uint8_t> moved(seen.points.size(), 0);
  for (std::size_t k = 0; k < moved.size(); ++k) {
    const auto column = static_cast<Index>(k);
    const bool colored = median.colored[static_cast<std::size_t>(seen.points[k])] != 0;
    const float error = (predicted.col(column) - seen.values.col(column)).cwiseAbs().mean();
    moved[k] = colored && error > static_cast<float>(threshold) ? 1 : 0;
  }
  return moved;
}

HeldoutErrors compareWithImage(const ColoredMap& map, const SeenImage& seen, const std::vector<std::uint8_t>& moved,
                               const std::vector<Edge>& neighbors) {
  HeldoutErrors errors;
  const Values raw = predict(map, seen, false), corrected = predict(map, seen, true);
  errors.visible = seen.points.size();
  for (std::size_t k = 0; k < seen.points.size(); ++k) {
    if (map.colored[static_cast<std::size_t>(seen.points[k])] == 0) continue;
    const auto column = static_cast<Index>(k);
    ++errors.colored;
    errors.raw.push_back((raw.col(column) - seen.values.col(column)).cwiseAbs().mean());
    errors.after_gain.push_back((corrected.col(column) - seen.values.col(column)).cwiseAbs().mean());
    errors.squares += (corrected.col(column) - seen.values.col(column)).squaredNorm();
    if (moved[k] == 0) errors.trimmed.push_back(errors.after_gain.back());
    errors.moved += moved[k];
  }
  addSeams(map, seen, corrected, moved, neighbors, errors);
  return errors;
}

std::vector<Edge> shortLinks(PointsRef points) {
  ZOrderGrid grid;
  grid.origin = points.rowwise().minCoeff();
  grid.cell = std::max(1e-3F, (points.rowwise().maxCoeff() - grid.origin).maxCoeff() / static_cast<float>(1 << 20));
  GraphParams params;
  params.passes = 1;
  std::vector<Edge> edges = zorderGraph(points, grid, params);
  std::vector<float> lengths;
  lengths.reserve(edges.size());
  for (const Edge& edge : edges) lengths.push_back((points.col(edge.p) - points.col(edge.q)).norm());
  const auto limit = static_cast<float>(3 * median(lengths));
  edges.erase(std::remove_if(edges.begin(), edges.end(),
                             [&](const Edge& e) { return !((points.col(e.p) - points.col(e.q)).norm() <= limit); }),
              edges.end());
  return edges;
}

}  // namespace cloud_colorizer
