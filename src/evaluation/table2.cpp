// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause

/// Table 2 of the paper: time by stage and peak memory, by graph, solver and number of points.
#include <algorithm>
#include <cstring>
#include <set>

#include "base/parallel.hpp"
#include "cloud_colorizer/base/check.hpp"
#include "evaluation/neighbors.hpp"
#include "evaluation/random.hpp"
#include "evaluation/tables.hpp"

namespace cloud_colorizer {
namespace {

using Eigen::Index;

constexpr std::size_t kViews = 24, kViewsOfAPoint = 8;

/// What a point sees: the eight of 24 directions around the object that it faces most. Solving does not care whether
/// visibility is exact, so the observations of six million points are made without images.
Observations syntheticObservations(const SurfaceSamples& samples) {
  const std::vector<Eigen::Isometry3d> poses = posesAround(static_cast<int>(kViews), 3.4);
  const auto n = static_cast<std::size_t>(samples.points.cols());
  Observations observations;
  observations.offsets.resize(n + 1);
  observations.views.resize(n * kViewsOfAPoint);
  observations.distances.assign(n * kViewsOfAPoint, 2.5F);
  observations.weights.assign(n * kViewsOfAPoint, 1.F);
  observations.values.resize(3, static_cast<Index>(n * kViewsOfAPoint));
  for (std::size_t p = 0; p <= n; ++p) observations.offsets[p] = static_cast<std::uint32_t>(p * kViewsOfAPoint);
  constexpr std::size_t kBlock = 8192;
  parallelFor(0, (n + kBlock - 1) / kBlock, [&](std::size_t block) {
    std::vector<std::pair<float, std::uint32_t>> facing(kViews);
    for (std::size_t p = block * kBlock; p < std::min(n, (block + 1) * kBlock); ++p) {
      const auto column = static_cast<Index>(p);
      for (std::size_t v = 0; v < kViews; ++v) {
        const Eigen::Vector3f towards = poses[v].translation().normalized().cast<float>();
        facing[v] = {-towards.dot(samples.normals.col(column)), static_cast<std::uint32_t>(v)};
      }
      std::partial_sort(facing.begin(), facing.begin() + kViewsOfAPoint, facing.end());
      std::sort(facing.begin(), facing.begin() + kViewsOfAPoint,
                [](const auto& a, const auto& b) { return a.second < b.second; });
      const Eigen::Vector3f color = shadedColor(samples.points.col(column), samples.normals.col(column), 1);
      for (std::size_t k = 0; k < kViewsOfAPoint; ++k) {
        const std::size_t at = p * kViewsOfAPoint + k;
        observations.views[at] = facing[k].second;
        const auto gain = static_cast<float>(1 + 0.1 * gaussian(17, facing[k].second));
        for (int c = 0; c < 3; ++c) {
          observations.values(c, static_cast<Index>(at)) =
              gain * color[c] + static_cast<float>(10 * (uniform(18, 3 * at + static_cast<std::size_t>(c)) - 0.5));
        }
      }
    }
  });
  return observations;
}

struct Measured {
  SolveSeconds seconds;
  double neighbours = 0;
};

LimitedRun measure(const Mesh& mesh, const std::string& graph, SolverKind solver, std::size_t size,
                   const TablesParams& params) {
  return runLimited(
      [&] {
        const SurfaceSamples samples = sampleSurface(mesh, size, 5);
        const Observations observations = syntheticObservations(samples);
        SystemParams system = params.method.system;
        system.min_data_weight = 0;
        system.solver = solver;
        const GraphSolution solution =
            solveOnGraph(graph, samples.points, observations, fuseMean(observations), system, Unanchored::kAnchored);
        const Measured measured{solution.seconds,
                                2 * static_cast<double>(solution.num_edges) / static_cast<double>(size)};
        return std::string(reinterpret_cast<const char*>(&measured), sizeof measured);
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
  require(run.bytes.size() == sizeof m, "a result from a child process is cut off");
  std::memcpy(&m, run.bytes.data(), sizeof m);
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

Table makeTable2(const Mesh& mesh, const TablesParams& params, const Callbacks& callbacks) {
  Table table;
  table.header = {"graph",    "solver",  "points",  "status",       "graph_s", "gradients_s", "system_s",
                  "factor_s", "solve_s", "total_s", "us_per_point", "peak_mb", "neighbours"};
  const std::vector<std::string> graphs = {"1-pass",        "2-pass", "3-pass", "4-pass",
                                           "4-pass shared", "5-NN",   "20-NN",  "DT"};
  const std::vector<std::pair<std::string, SolverKind>> solvers = {
      {"CG", SolverKind::kConjugateGradients}, {"CHOLMOD", SolverKind::kCholmod}, {"SuiteSparseQR", SolverKind::kSpqr}};
  std::size_t done = 0;
  Mesh object = mesh;
  normalizeMesh(object);
  for (const std::string& graph : graphs) {
    for (const auto& [solver, kind] : solvers) {
      std::string stopped;
      for (const std::size_t size : params.table2_sizes) {
        if (callbacks.cancelled && callbacks.cancelled()) throw Cancelled();
        LimitedRun run;
        if ((graph == "DT" && !hasDelaunay()) || (graph.find("NN") != std::string::npos && !hasNearestNeighbors())) {
          run.status = "not built";
        } else if (!stopped.empty()) {
          run.status = stopped;
        } else {
          run = measure(object, graph, kind, size, params);
        }
        if (run.status != "ok" && stopped.empty()) stopped = run.status + " at " + std::to_string(size) + " already";
        table.add(cells(graph, solver, size, run));
        if (callbacks.progress) {
          callbacks.progress({"table 2", ++done, solvers.size() * graphs.size() * params.table2_sizes.size(), 0, -1});
        }
      }
    }
  }
  return table;
}

}  // namespace cloud_colorizer
