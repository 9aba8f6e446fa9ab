// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause

/// Ablations: one parameter at a time, on one mesh.
#include <algorithm>
#include <cmath>
#include <sstream>

#include "base/columns.hpp"
#include "base/progress.hpp"
#include "base/stop_watch.hpp"
#include "cloud_colorizer/color/point_colors.hpp"
#include "evaluation/tables.hpp"

namespace cloud_colorizer {
namespace {

using Eigen::Index;

constexpr std::size_t kNumRows = 84;  // 42 with each kind of noise

/// The paper's method with every parameter free (the preset `paper` fixes some of them).
Values solvePaper(PointsRef points, const Observations& observations, const ZOrderGrid& grid, const Params& params) {
  return solveValues(points, observations, fuseMean(observations), grid, params.graph, params.system);
}

Params paperParams(const Params& from) {
  Params params = from;
  params.system.min_data_weight = 0;
  return params;
}

std::vector<std::string> scored(const std::string& what, const std::string& value, const std::string& noise,
                                const TestBed& bed, const ObservedBed& observed, const Values& values, double seconds,
                                double seam) {
  const Score score = scoreColors(seenTruth(bed, observed), values, std::vector<std::uint8_t>(observed.seen.size(), 1));
  const double coverage = static_cast<double>(observed.seen.size()) / static_cast<double>(bed.points.cols());
  return {what,
          value,
          noise,
          formatNumber(score.aep, 3),
          formatNumber(score.rep, 4),
          formatNumber(coverage, 4),
          formatNumber(seconds, 2),
          formatNumber(seam, 3)};
}

/// All of them with one kind of noise.
class Ablations {
 public:
  Ablations(const Mesh& mesh, const TablesParams& params, const std::string& noise, ProgressMeter& meter,
            ResultTable& table)
      : mesh_(mesh), params_(params), noise_(noise), meter_(meter), paper_(paperParams(params.method)), table_(table) {
    bed_ = bedWith(params.bed);
    observed_ = observeBed(bed_, bed_.poses, {}, params.method);
  }

  void run() {
    solver();
    views();
    chunks();
    texture();
  }

 private:
  TestBed bedWith(const TestBedParams& params) const {
    return noisyBed(mesh_, params, noise_ == "both" ? params_.noise : params_.noise.onlyIntensities());
  }

  void report(const std::vector<std::string>& row) {
    table_.add(row);
    meter_.add(1, false);
  }

  void solve(const std::string& what, const std::string& value, const Params& params, const ObservedBed& observed) {
    ProcessorWatch watch;
    const Values values = solvePaper(observed.points, observed.observations, gridOf(observed.points), params);
    const double seconds = watch.lap();
    report(scored(what, value, noise_, bed_, observed, values, seconds, std::nan("")));
  }

  template <class T, class Set>
  void vary(const std::string& what, const std::vector<T>& values, const Set& set) {
    for (const T value : values) {
      Params params = paper_;
      set(params, value);
      std::ostringstream text;
      text << value;
      solve(what, text.str(), params, observed_);
    }
  }

  void solver() {
    vary<int>("passes", {1, 2, 3, 4}, [](Params& p, int v) { p.graph.passes = v; });
    vary<double>("anchor_share_random", {0.01, 0.03, 0.1, 0.3, 1},
                 [](Params& p, double v) { p.system.anchor_share = v; });
    vary<double>("anchor_share_consistent", {0.01, 0.03, 0.1, 0.3, 1}, [](Params& p, double v) {
      p.system.anchor_share = v;
      p.system.anchors = AnchorKind::kConsistent;
    });
    vary<double>("lambda", {0.01, 0.1, 1, 10, 100}, [](Params& p, double v) { p.system.lambda = v; });
    vary<double>("gradient_distance", {0, 2.6, 2.8, 3.0, 3.2},
                 [](Params& p, double v) { p.system.gradient_distance = v; });
  }

  /// What is seen, and by how many views.
  void views() {
    for (const int max_views : {1, 3, 5, 10, 20, 48}) {
      Params params = paper_;
      params.observe.max_views = max_views;
      solve("max_views", std::to_string(max_views), params, observeBed(bed_, bed_.poses, {}, params));
    }
    for (const int cell : {1, 2, 4, 8}) {
      Params params = paper_;
      params.depth.depth_cell_size = cell;
      solve("depth_cell_size", std::to_string(cell), params, observeBed(bed_, bed_.poses, {}, params));
    }
  }

  /// The object in 2 x 2 x 2 chunks with a halo; the seam is the mean difference from the solution in one piece of the
  /// points within 5 % of a chunk's side from a border. A chunk's side is 1, half the diameter.
  void chunks() {
    const ZOrderGrid grid = gridOf(observed_.points);
    const Values whole = solvePaper(observed_.points, observed_.observations, grid, paper_);
    for (const int percent : {0, 5, 10, 20}) {
      ProcessorWatch watch;
      Values values = Values::Zero(3, observed_.points.cols());
      for (int chunk = 0; chunk < 8; ++chunk) solveChunk(chunk, static_cast<float>(percent) / 100, grid, values);
      const double seconds = watch.lap();
      double sum = 0;
      Index count = 0;
      for (Index p = 0; p < values.cols(); ++p) {
        if (observed_.points.col(p).cwiseAbs().minCoeff() > 0.05F) continue;
        sum += (values.col(p) - whole.col(p)).cwiseAbs().mean();
        ++count;
      }
      report(scored("overlap_percent", std::to_string(percent), noise_, bed_, observed_, values, seconds,
                    sum / static_cast<double>(std::max<Index>(1, count))));
    }
  }

  void solveChunk(int chunk, float overlap, const ZOrderGrid& grid, Values& values) const {
    std::vector<Index> members, core;
    for (Index p = 0; p < observed_.points.cols(); ++p) {
      bool inside = true, in_core = true;
      for (int axis = 0; axis < 3; ++axis) {
        const float side = (chunk >> axis & 1) == 1 ? observed_.points(axis, p) : -observed_.points(axis, p);
        inside = inside && side >= -overlap;
        in_core = in_core && (side > 0 || (side == 0 && (chunk >> axis & 1) == 1));
      }
      if (!inside) continue;
      if (in_core) core.push_back(static_cast<Index>(members.size()));
      members.push_back(p);
    }
    if (core.empty()) return;
    const Observations part = rowsOf(observed_.observations, members);
    const Values solved = solvePaper(gatherColumns(observed_.points, members), part, grid, paper_);
    for (const Index k : core) values.col(members[static_cast<std::size_t>(k)]) = solved.col(k);
  }

  static Observations rowsOf(const Observations& all, const std::vector<Index>& members) {
    Observations part;
    part.offsets.push_back(0);
    std::vector<Index> columns;
    for (const Index p : members) {
      for (std::uint32_t o = all.offsets[static_cast<std::size_t>(p)]; o < all.offsets[static_cast<std::size_t>(p) + 1];
           ++o) {
        columns.push_back(o);
        part.views.push_back(all.views[o]);
        part.distances.push_back(all.distances[o]);
        part.weights.push_back(all.weights[o]);
      }
      part.offsets.push_back(static_cast<std::uint32_t>(columns.size()));
    }
    part.values = gatherColumns(all.values, columns);
    return part;
  }

  void texture() {
    const TestBed original = bed_;
    for (const double frequency : {0.5, 1.0, 2.0, 4.0}) {
      TestBedParams params = params_.bed;
      params.texture_frequency = frequency;
      bed_ = bedWith(params);
      solve("texture_frequency", formatNumber(frequency, 1), paper_, observeBed(bed_, bed_.poses, {}, paper_));
    }
    bed_ = original;
  }

  const Mesh& mesh_;
  const TablesParams& params_;
  const std::string noise_;
  ProgressMeter& meter_;
  Params paper_;
  ResultTable& table_;
  TestBed bed_;
  ObservedBed observed_;
};

}  // namespace

ResultTable makeAblations(const Mesh& mesh, const TablesParams& params, const Callbacks& callbacks) {
  ResultTable table;
  table.header = {"what", "value", "noise", "aep", "rep", "coverage", "seconds", "seam"};
  ProgressMeter meter(callbacks, "ablations", kNumRows);
  for (const std::string noise : {"both", "intensities"}) Ablations(mesh, params, noise, meter, table).run();
  return table;
}

}  // namespace cloud_colorizer
