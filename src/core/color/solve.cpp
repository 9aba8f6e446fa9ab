// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause
#include "cloud_colorizer/color/solve.hpp"

#include <utility>

#include "base/stop_watch.hpp"
#include "cloud_colorizer/base/check.hpp"

namespace cloud_colorizer {
namespace {

void checkSeen(PointsRef points, const Observations& observations, const Fused& data) {
  checkObservations(observations);
  require<std::invalid_argument>(static_cast<Eigen::Index>(observations.numPoints()) == points.cols() &&
                                     data.values.cols() == points.cols() && data.count.size() == points.cols(),
                                 points.cols(), " points, observations of ", observations.numPoints(),
                                 " and fused values of ", data.values.cols(), " must be equally many");
  require<std::invalid_argument>(points.cols() == 0 || data.count.minCoeff() > 0,
                                 "a point without views cannot be in the graph: leave it out");
}

}  // namespace

Solution solveWithStatistics(PointsRef points, const Observations& observations, const Fused& data,
                             const ZOrderGrid& grid, const GraphParams& graph_params,
                             const SystemParams& system_params) {
  system_params.check();
  checkSeen(points, observations, data);
  Solution solution;
  StopWatch watch;
  OrderedGraph graph = orderedZorderGraph(points, grid, graph_params);  // N of eq. (3)
  std::vector<Edge> edges = std::move(graph.edges);
  solution.num_edges = edges.size();
  solution.seconds.graph = watch.lap();
  Gradients gradients =  // eq. (4)
      edgeGradients(edges, observations, system_params.gradient_distance, data.observation_weights);
  edges = weighEvidence(std::move(edges), gradients, system_params.no_evidence_weight);
  solution.seconds.gradients = watch.lap();
  const Eigen::VectorXf data_weights = dataWeights(points, data, edges, system_params);  // a_p of eq. (2)
  const LinearSystem system =                                                            // eq. (5)
      assembleSystem(edges, gradients.values, data.values, data_weights, system_params.lambda);
  solution.seconds.assembly = watch.lap();
  edges = {};  // the factor is the largest object of all; make room for it
  gradients = {};
  const LinearSolver solver(system.matrix, system_params.solver, graph.elimination_order);
  solution.seconds.factor = watch.lap();
  const Eigen::MatrixXd guess = data.values.transpose().cast<double>();
  solution.values = solver.solve(system.rhs, guess).transpose().cast<float>();
  solution.seconds.solve = watch.lap();
  return solution;
}

Values solveValues(PointsRef points, const Observations& observations, const Fused& data, const ZOrderGrid& grid,
                   const GraphParams& graph_params, const SystemParams& system_params) {
  return solveWithStatistics(points, observations, data, grid, graph_params, system_params).values;
}

}  // namespace cloud_colorizer
