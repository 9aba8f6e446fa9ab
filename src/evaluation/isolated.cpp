// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause

/// Parts of a graph that are cut off from all anchors, by graph and by the way the points were sampled.
#include <algorithm>
#include <map>

#include "cloud_colorizer/check.hpp"
#include "cloud_colorizer/evaluation/neighbors.hpp"
#include "cloud_colorizer/evaluation/tables.hpp"

namespace cloud_colorizer {
namespace {

struct Parts {
  std::size_t count = 0;
  double largest = 0;  ///< share of the points
};

Parts partsOf(const std::string& graph, PointsRef points) {
  const auto num_points = static_cast<std::size_t>(points.cols());
  std::map<std::uint32_t, std::size_t> sizes;
  for (const std::uint32_t label : connectedComponents(num_points, buildGraph(graph, points).edges)) ++sizes[label];
  Parts parts{sizes.size(), 0};
  for (const auto& [label, size] : sizes) {
    parts.largest = std::max(parts.largest, static_cast<double>(size) / static_cast<double>(num_points));
  }
  return parts;
}

Values truthOf(const TestBed& bed, const ObservedBed& observed) {
  Values truth(3, observed.points.cols());
  for (std::size_t k = 0; k < observed.seen.size(); ++k) {
    truth.col(static_cast<Eigen::Index>(k)) = bed.truth.col(observed.seen[k]);
  }
  return truth;
}

}  // namespace

Table makeIsolated(const Mesh& mesh, const TablesParams& params, const Callbacks& callbacks) {
  constexpr std::size_t kMostPoints = 65000;  // the share does not depend on it: uniform samples look alike at any size
  Table table;
  table.header = {"sampling",           "graph",     "points", "parts", "largest_part_percent",
                  "unanchored_percent", "plain_aep", "aep"};
  std::size_t done = 0;
  for (const double ratio : {0.0, 5.0, 10.0}) {
    TestBedParams bed_params = params.bed;
    bed_params.num_points = std::min(kMostPoints, params.bed.num_points);
    bed_params.scan_line_ratio = ratio;
    const TestBed bed =
        addNoise(renderTestBed(mesh, bed_params), params.noise, bed_params.seed, bed_params.num_threads);
    const ObservedBed observed = observeBed(bed, bed.poses, {}, params.method);
    const Values truth = truthOf(bed, observed);
    const Fused mean = fuseMean(observed.observations);
    SystemParams system = params.method.system;
    system.min_data_weight = 0;  // as in the paper
    for (const std::string graph : {"5-NN", "20-NN", "4-pass"}) {
      if (callbacks.cancelled && callbacks.cancelled()) throw Cancelled();
      if (graph != "4-pass" && !hasNearestNeighbors()) continue;
      const auto solve = [&](Unanchored unanchored) {
        return solveOnGraph(graph, observed.points, observed.observations, mean, system, unanchored);
      };
      const auto aep = [&](const GraphSolution& solution) {
        return scoreColors(truth, solution.values, std::vector<std::uint8_t>(observed.seen.size(), 1)).aep;
      };
      const Parts parts = partsOf(graph, observed.points);
      const GraphSolution plain = solve(Unanchored::kPlain), anchored = solve(Unanchored::kAnchored);
      table.add({ratio == 0 ? "uniform" : "scan lines 1 : " + formatNumber(ratio, 0), graph,
                 std::to_string(observed.seen.size()), std::to_string(parts.count),
                 formatNumber(100 * parts.largest, 1), formatNumber(100 * plain.unanchored_share, 3),
                 formatNumber(aep(plain), 3), formatNumber(aep(anchored), 3)});
      if (callbacks.progress) callbacks.progress({"isolated parts", ++done, 9, 0, -1});
    }
  }
  return table;
}

}  // namespace cloud_colorizer
