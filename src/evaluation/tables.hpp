// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause

/// The paper's tables 1 and 2, its figure 4, and our ablations.
#pragma once

#include <opencv2/core.hpp>
#include <string>
#include <vector>

#include "evaluation/limited.hpp"
#include "evaluation/methods.hpp"
#include "evaluation/table.hpp"

namespace cloud_colorizer {

struct TablesParams {
  TestBedParams bed;
  NoiseParams noise;  ///< of table 1, both kinds together; its parts make the other two kinds
  Limits limits;      ///< of one row
  Params method;      ///< parameters of all methods
  std::vector<std::size_t> density_sizes = {65000, 300000, 1000000};
  Limits density_limits{900, 12000};
  std::vector<std::size_t> table2_sizes = {65000, 890000, 980000, 1140000, 1670000, 5980000};

  static TablesParams quick();  ///< 65,000 points on one mesh, two sizes, short limits: for CI
};

/// All meshes of a directory (*.ply, by name), or the built-in shapes where `directory` is empty. Throws
/// std::runtime_error when the directory has none.
std::vector<Mesh> loadMeshes(const std::string& directory);

struct MethodRun {
  std::string status = "ok";  ///< else what stopped it; the result then has its seconds alone
  MethodResult result;
};
/// colorizeArrays, for a graph in a process with limits, as a graph may take for ever. (The alignment of `default`
/// needs the threads of this one.)
MethodRun runMethod(const TestBed& bed, const ObservedBed& observed, const std::string& method, const Params& params,
                    const Limits& limits);

struct Table1 {
  ResultTable table;  ///< mesh, noise, method, status, aep, rep, ...
  cv::Mat closeup;    ///< BGR; the paper's figure 4: the first mesh by method
};
Table1 makeTable1(const std::vector<Mesh>& meshes, const TablesParams& params, const Callbacks& callbacks);

/// graph, solver, points, status, seconds by stage, peak memory, neighbours a node.
ResultTable makeTable2(const Mesh& mesh, const TablesParams& params, const Callbacks& callbacks);

/// Graphs on points sampled uniformly and in scan lines: number of parts, share of the points in parts without an
/// anchor, and the AEP with such parts left as the equations leave them, and with our rule.
ResultTable makeIsolated(const Mesh& mesh, const TablesParams& params, const Callbacks& callbacks);

/// Errors with noise of the intensities alone, by mesh and number of points: mean, 4-pass and 20-NN.
ResultTable makeDensity(const std::vector<Mesh>& meshes, const TablesParams& params, const Callbacks& callbacks);

/// Ablations on one mesh: what is varied, its value, kind of noise, AEP, REP, seconds, seam.
ResultTable makeAblations(const Mesh& mesh, const TablesParams& params, const Callbacks& callbacks);

}  // namespace cloud_colorizer
