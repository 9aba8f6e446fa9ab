// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause

/// Parts of a graph that are cut off from all anchors, by graph and by the way the points were sampled.
#include <algorithm>
#include <map>

#include "base/progress.hpp"
#include "base/text.hpp"
#include "evaluation/tables.hpp"

namespace cloud_colorizer {
namespace {

/// Cells of one row, with commas between: points, number of parts, share of the largest, share without an anchor,
/// errors plain and anchored.
std::string measureParts(const std::string& graph, const TestBed& bed, const ObservedBed& observed,
                         SystemParams system) {
  std::map<std::uint32_t, std::size_t> sizes;
  for (const std::uint32_t label :
       connectedComponents(observed.seen.size(), buildGraph(graph, observed.points).edges)) {
    ++sizes[label];
  }
  std::size_t largest = 0;
  for (const auto& [label, size] : sizes) largest = std::max(largest, size);
  system.min_data_weight = 0;  // as in the paper
  const Fused mean = fuseMean(observed.observations);
  const auto solve = [&](Unanchored unanchored) {
    return solveOnGraph(graph, observed.points, observed.observations, mean, system, unanchored);
  };
  const auto aep = [&](const GraphSolution& solution) {
    const std::vector<std::uint8_t> all(observed.seen.size(), 1);
    return formatNumber(scoreColors(seenTruth(bed, observed), solution.values, all).aep, 3);
  };
  const GraphSolution plain = solve(Unanchored::kPlain), anchored = solve(Unanchored::kAnchored);
  const auto count = static_cast<double>(observed.seen.size());
  return std::to_string(observed.seen.size()) + "," + std::to_string(sizes.size()) + "," +
         formatNumber(100 * static_cast<double>(largest) / count, 1) + "," +
         formatNumber(100 * plain.unanchored_share, 3) + "," + aep(plain) + "," + aep(anchored);
}

}  // namespace

ResultTable makeIsolated(const Mesh& mesh, const TablesParams& params, const Callbacks& callbacks) {
  constexpr std::size_t kMostPoints = 65000;  // the share does not depend on it: uniform samples look alike at any size
  ResultTable table{
      {"sampling", "graph", "points", "parts", "largest_part_percent", "unanchored_percent", "plain_aep", "aep"}, {}};
  ProgressMeter meter(callbacks, "isolated parts", 9);
  for (const double ratio : {0.0, 5.0, 10.0}) {
    TestBedParams bed_params = params.bed;
    bed_params.num_points = std::min(kMostPoints, params.bed.num_points);
    bed_params.scan_line_ratio = ratio;
    const TestBed bed = noisyBed(mesh, bed_params, params.noise);
    const ObservedBed observed = observeBed(bed, bed.poses, {}, params.method);
    for (const std::string graph : {"5-NN", "20-NN", "4-pass"}) {
      std::vector<std::string> row = {ratio == 0 ? "uniform" : "scan lines 1 : " + formatNumber(ratio, 0), graph};
      const LimitedRun run =
          runLimited([&] { return measureParts(graph, bed, observed, params.method.system); }, params.limits);
      std::vector<std::string> cells = {std::to_string(observed.seen.size()), run.status, "-", "-", "-", "-"};
      if (run.status == "ok") cells = splitAt(run.bytes, ',');
      row.insert(row.end(), cells.begin(), cells.end());
      table.add(row);
      meter.add(1, false);
    }
  }
  return table;
}

}  // namespace cloud_colorizer
