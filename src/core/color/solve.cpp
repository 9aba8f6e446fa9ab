// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause
#include "color/solve.hpp"

#include <utility>

#include "base/stop_watch.hpp"
#include "cloud_colorizer/base/check.hpp"

namespace cloud_colorizer {
namespace {

void checkSeen(const Observations& observations, const Fused& data) {
  checkObservations(observations);
  const auto num_points = static_cast<Eigen::Index>(observations.numPoints());
  require<std::invalid_argument>(data.values.cols() == num_points && data.count.size() == num_points,
                                 "observations of ", num_points, " points and fused values of ", data.values.cols(),
                                 " must be equally many");
  require<std::invalid_argument>(num_points == 0 || data.count.minCoeff() > 0,
                                 "a point without views cannot be in the graph: leave it out");
}

}  // namespace

Solution solveOnGraph(OrderedGraph graph, const Observations& observations, const Fused& data,
                      const SystemParams& params, const Anchoring& anchoring) {
  params.check();
  checkSeen(observations, data);
  Solution solution;
  ProcessorWatch watch;
  std::vector<Edge> edges = std::move(graph.edges);  // N of eq. (3)
  Gradients gradients = edgeGradients(edges, observations, params.gradient_distance, data.observation_weights);  // (4)
  edges = weighEvidence(std::move(edges), gradients, params.no_evidence_weight);
  solution.seconds.gradients = watch.lap();
  Values values = data.values;
  const Eigen::VectorXf data_weights = anchoring(edges, values);  // a_p of eq. (2)
  const LinearSystem system = assembleSystem(edges, gradients.values, values, data_weights, params.lambda);  // eq. (5)
  solution.seconds.assembly = watch.lap();
  edges = {};  // the factor is the largest object of all; make room for it
  gradients = {};
  values = {};
  const LinearSolver solver(system.matrix, params.solver, graph.elimination_order);
  solution.seconds.factor = watch.lap();
  const Eigen::MatrixXd guess = data.values.transpose().cast<double>();
  solution.values = solver.solve(system.rhs, guess).transpose().cast<float>();
  solution.seconds.solve = watch.lap();
  return solution;
}

Values solveValues(PointsRef points, const Observations& observations, const Fused& data, const ZOrderGrid& grid,
                   GraphParams graph_params, const SystemParams& system_params) {
  require<std::invalid_argument>(static_cast<Eigen::Index>(observations.numPoints()) == points.cols(), points.cols(),
                                 " points and observations of ", observations.numPoints(), " must be equally many");
  const bool factors = system_params.solver != SolverKind::kConjugateGradients;
  if (graph_params.grids == PassGrids::kAuto) graph_params.grids = factors ? PassGrids::kShared : PassGrids::kOwn;
  const auto anchoring = [&](const std::vector<Edge>& edges, Values&) {
    return dataWeights(points, data, edges, system_params);
  };
  return solveOnGraph(orderedZorderGraph(points, grid, graph_params), observations, data, system_params, anchoring)
      .values;
}

}  // namespace cloud_colorizer
