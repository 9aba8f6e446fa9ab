// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause

/// Table 2 of the paper: time by stage and peak memory, by graph, solver and number of points.
#include <algorithm>
#include <array>

#include "base/parallel.hpp"
#include "base/progress.hpp"
#include "evaluation/neighbors.hpp"
#include "evaluation/random.hpp"
#include "evaluation/tables.hpp"

namespace cloud_colorizer {
namespace {

using Eigen::Index;

constexpr std::size_t kViews = 24, kViewsOfAPoint = 8;

/// What a point sees: the eight of 24 directions around the object that it faces most. Solving does not care whether
/// visibility is exact, so the observations of six million points are made without images.
class SyntheticViews {
 public:
  explicit SyntheticViews(const SurfaceSamples& samples)
      : samples_(samples), poses_(posesAround(static_cast<int>(kViews), 3.4)) {}

  Observations observe() const {
    constexpr std::size_t kBlock = 8192;
    const auto n = static_cast<std::size_t>(samples_.points.cols());
    Observations observations;
    observations.offsets.resize(n + 1);
    observations.views.resize(n * kViewsOfAPoint);
    observations.distances.assign(n * kViewsOfAPoint, 2.5F);
    observations.weights.assign(n * kViewsOfAPoint, 1.F);
    observations.values.resize(3, static_cast<Index>(n * kViewsOfAPoint));
    for (std::size_t p = 0; p <= n; ++p) observations.offsets[p] = static_cast<std::uint32_t>(p * kViewsOfAPoint);
    parallelFor(0, (n + kBlock - 1) / kBlock, [&](std::size_t block) {
      for (std::size_t p = block * kBlock; p < std::min(n, (block + 1) * kBlock); ++p) look(p, observations);
    });
    return observations;
  }

 private:
  void look(std::size_t p, Observations& observations) const {
    const auto column = static_cast<Index>(p);
    const Eigen::Vector3f color = shadedColor(samples_.points.col(column), samples_.normals.col(column), 1);
    const std::array<std::uint32_t, kViewsOfAPoint> views = facedMost(samples_.normals.col(column));
    for (std::size_t k = 0; k < kViewsOfAPoint; ++k) {
      const std::size_t at = p * kViewsOfAPoint + k;
      observations.views[at] = views[k];
      const auto gain = static_cast<float>(1 + 0.1 * gaussian(17, views[k]));
      for (int c = 0; c < 3; ++c) {
        const double noise = 10 * (uniform(18, 3 * at + static_cast<std::size_t>(c)) - 0.5);
        observations.values(c, static_cast<Index>(at)) = gain * color[c] + static_cast<float>(noise);
      }
    }
  }

  std::array<std::uint32_t, kViewsOfAPoint> facedMost(const Eigen::Vector3f& normal) const {
    std::array<std::pair<float, std::uint32_t>, kViews> facing;
    for (std::size_t v = 0; v < kViews; ++v) {
      const Eigen::Vector3f towards = poses_[v].translation().normalized().cast<float>();
      facing[v] = {-towards.dot(normal), static_cast<std::uint32_t>(v)};
    }
    std::partial_sort(facing.begin(), facing.begin() + kViewsOfAPoint, facing.end());
    std::array<std::uint32_t, kViewsOfAPoint> views;
    for (std::size_t k = 0; k < kViewsOfAPoint; ++k) views[k] = facing[k].second;
    std::sort(views.begin(), views.end());
    return views;
  }

  const SurfaceSamples& samples_;
  const std::vector<Eigen::Isometry3d> poses_;
};

struct Measured {
  SolveSeconds seconds;
  double neighbours = 0;
};

LimitedRun measure(const Mesh& mesh, const std::string& graph, SolverKind solver, std::size_t size,
                   const TablesParams& params) {
  return runLimited(
      [&] {
        const SurfaceSamples samples = sampleSurface(mesh, size, 5);
        const Observations observations = SyntheticViews(samples).observe();
        SystemParams system = params.method.system;
        system.min_data_weight = 0;
        system.solver = solver;
        const GraphSolution solution =
            solveOnGraph(graph, samples.points, observations, fuseMean(observations), system, Unanchored::kAnchored);
        const Measured measured{solution.seconds,
                                2 * static_cast<double>(solution.num_edges) / static_cast<double>(size)};
        std::string bytes;
        appendBytes(bytes, &measured, 1);
        return bytes;
      },
      params.limits);
}

std::vector<std::string> cells(const std::string& graph, const std::string& solver, std::size_t size,
                               const LimitedRun& run) {
  std::vector<std::string> row = {graph, solver, std::to_string(size), run.status};
  if (run.status != "ok") {
    row.insert(row.end(), {"-", "-", "-", "-", "-", "-", "-", formatNumber(run.peak_megabytes, 0), "-"});
    return row;
  }
  Measured m;
  std::size_t at = 0;
  takeBytes(run.bytes, at, &m, 1);
  const SolveSeconds& s = m.seconds;
  for (const double seconds : {s.graph, s.gradients, s.assembly, s.factor, s.solve, s.total()}) {
    row.push_back(formatNumber(seconds, 3));
  }
  row.push_back(formatNumber(1e6 * s.total() / static_cast<double>(size), 3));
  row.push_back(formatNumber(run.peak_megabytes, 0));
  row.push_back(formatNumber(m.neighbours, 2));
  return row;
}

}  // namespace

ResultTable makeTable2(const Mesh& mesh, const TablesParams& params, const Callbacks& callbacks) {
  ResultTable table;
  table.header = {"graph",    "solver",  "points",  "status",       "graph_s", "gradients_s", "system_s",
                  "factor_s", "solve_s", "total_s", "us_per_point", "peak_mb", "neighbours"};
  const std::vector<std::string> graphs = {"1-pass",        "2-pass", "3-pass", "4-pass",
                                           "4-pass shared", "5-NN",   "20-NN",  "DT"};
  const std::vector<std::pair<std::string, SolverKind>> solvers = {
      {"CG", SolverKind::kConjugateGradients}, {"CHOLMOD", SolverKind::kCholmod}, {"SuiteSparseQR", SolverKind::kSpqr}};
  ProgressMeter meter(callbacks, "table 2", solvers.size() * graphs.size() * params.table2_sizes.size());
  Mesh object = mesh;
  normalizeMesh(object);
  for (const std::string& graph : graphs) {
    for (const auto& [solver, kind] : solvers) {
      std::string stopped;
      for (const std::size_t size : params.table2_sizes) {
        LimitedRun run;
        if (graph == "DT" && !hasDelaunay()) {
          run.status = "not built";
        } else if (!stopped.empty()) {
          run.status = stopped;
        } else {
          run = measure(object, graph, kind, size, params);
        }
        if (run.status != "ok" && stopped.empty()) stopped = run.status + " at " + std::to_string(size) + " already";
        table.add(cells(graph, solver, size, run));
        meter.add(1, false);
      }
    }
  }
  return table;
}

}  // namespace cloud_colorizer
