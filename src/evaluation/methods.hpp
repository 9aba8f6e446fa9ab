// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause

/// The methods that are compared, all on the same observations of a test bed.
#pragma once

#include <string>
#include <vector>

#include "cloud_colorizer/map/params.hpp"
#include "cloud_colorizer/visibility/observe.hpp"
#include "color/solve.hpp"
#include "evaluation/score.hpp"
#include "evaluation/test_bed.hpp"

namespace cloud_colorizer {

/// The points of a test bed that some view sees, with what the views saw. Everything has one column a seen point.
struct ObservedBed {
  std::vector<Eigen::Index> seen;  ///< into TestBed::points
  Points points;
  Observations observations;
  ObserveStats stats;
  double seconds = 0;  ///< of a processor: surfels, depth images and observation
};

/// The views of a bed with the given poses, and exposures and weights if any (one a view), each with the depth image of
/// all points. `camera` is the bed's; the views point to it.
std::vector<ObservedView> observedViews(const TestBed& bed, const Surfels& surfels, const Camera& camera,
                                        const std::vector<Eigen::Isometry3d>& poses,
                                        const std::vector<Exposure>& exposures, const std::vector<float>& weights,
                                        const Params& params);

/// Visibility and observation with the given poses, and exposures and weights if any (one a view).
ObservedBed observeBed(const TestBed& bed, const std::vector<Eigen::Isometry3d>& poses,
                       const std::vector<Exposure>& exposures, const Params& params,
                       const std::vector<float>& weights = {});

/// The true colours of the seen points.
Values seenTruth(const TestBed& bed, const ObservedBed& observed);

enum class Unanchored {
  kPlain,    ///< as the equations are: a rank-deficient part has the basic solution, one of its points at zero
  kAnchored  ///< our rule: every part gets an anchor
};

struct GraphSolution {
  Values values;         ///< not clamped
  SolveSeconds seconds;  ///< of a processor
  std::size_t num_edges = 0;
  double unanchored_share = 0;  ///< share of points in parts without a random anchor
};

/// The paper's formulation on any of its graphs: "1-pass" ... "4-pass", also "4-pass shared" (PassGrids::kShared),
/// "5-NN", "20-NN" (any k), "DT".
/// Throws std::invalid_argument for another name, std::runtime_error when the graph was not built in.
GraphSolution solveOnGraph(const std::string& graph, const Points& points, const Observations& observations,
                           const Fused& data, const SystemParams& params, Unanchored unanchored);

/// The edges of such a graph; the order of elimination is empty but for shared grids.
OrderedGraph buildGraph(const std::string& graph, const Points& points);

struct MethodResult {
  Values values;                      ///< 3 x n of the test bed
  std::vector<std::uint8_t> colored;  ///< n
  double seconds = 0;  ///< of a processor, from observations to colours; `default`: with alignment, second observation
  double edges_per_point = 0, unanchored_share = 0;
  double reprojection_error = 0;  ///< px, of the poses that were used
  double gain_error = 0;          ///< mean |gain * estimated correction / mean of it - 1| of the views
};

/// Names of the rows of Table 1, in order. A graph's name may be followed by " plain" (see Unanchored).
std::vector<std::string> methodNames();

/// Colours the test bed by one method: closest, mean, median, a graph's name, paper (= 4-pass), default.
MethodResult colorizeArrays(const TestBed& bed, const ObservedBed& observed, const std::string& method,
                            const Params& params);

}  // namespace cloud_colorizer
