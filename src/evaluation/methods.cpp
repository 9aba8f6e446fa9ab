// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause
#include "evaluation/methods.hpp"

#include <algorithm>
#include <cmath>

#include "base/parallel.hpp"
#include "base/stop_watch.hpp"
#include "base/text.hpp"
#include "cloud_colorizer/alignment/align.hpp"
#include "cloud_colorizer/base/check.hpp"
#include "cloud_colorizer/color/point_colors.hpp"
#include "surface/surface.hpp"
#include "visibility/seen_points.hpp"

namespace cloud_colorizer {
namespace {

using Eigen::Index;

std::shared_ptr<const DepthImage> depthOf(PointsRef points, const Surfels& surfels, const Camera& camera,
                                          const Eigen::Isometry3d& pose, const DepthParams& params) {
  DepthSplatter splatter(camera, pose.inverse().cast<float>(), params);
  splatter.add(points, surfels);
  return std::make_shared<const DepthImage>(splatter.finish());
}

AlignmentInput alignmentInput(const TestBed& bed, const Params& params) {
  AlignmentInput input;
  input.cameras.emplace_back(bed.intrinsics);
  for (const Eigen::Isometry3d& pose : bed.poses) {
    View view;
    view.map_from_camera = pose;
    view.stamp = static_cast<double>(input.views.size());
    input.views.push_back(view);
  }
  input.images = [&bed](std::size_t v) { return std::make_shared<const cv::Mat>(bed.images[v]); };
  input.depth_params = params.depth;
  input.num_threads = params.colorize.num_threads;
  return input;
}

/// Poses and exposures by the alignment, on a sample of the points; visibility from all of them.
AlignmentResult alignBed(const TestBed& bed, const Params& params) {
  constexpr std::size_t kViewsPerPoint = 8;  // as the runner has it
  const auto wanted = static_cast<Index>(static_cast<std::size_t>(params.alignment.alignment_points) *
                                         bed.poses.size() / kViewsPerPoint);
  AlignmentInput input = alignmentInput(bed, params);
  const Surfels surfels = estimateSurfels(bed.points, params.surfels);
  const Index step = std::max<Index>(1, bed.points.cols() / std::max<Index>(1, wanted));
  std::vector<Index> columns;
  for (Index p = 0; p + step <= bed.points.cols(); p += step) columns.push_back(p);
  Surface sample = gatherSurface({bed.points, surfels}, columns);
  input.points = std::move(sample.points);
  input.surfels = std::move(sample.surfels);
  input.depth = [&](std::size_t, const Eigen::Isometry3d& pose) {
    return depthOf(bed.points, surfels, input.cameras[0], pose, params.depth);
  };
  return align(input, params.alignment, Callbacks{});
}

double gainError(const TestBed& bed, const std::vector<Exposure>& exposures) {
  std::vector<double> products;
  double mean = 0;
  for (std::size_t v = 0; v < exposures.size(); ++v) {
    const double gain = exposures[v].gain.size() > 0 ? exposures[v].gain.mean() : 1;
    products.push_back(gain * bed.gains[static_cast<Index>(v)]);
    mean += products.back() / static_cast<double>(exposures.size());
  }
  double sum = 0;
  for (const double product : products) sum += std::abs(product / mean - 1);
  return products.empty() ? 0 : sum / static_cast<double>(products.size());
}

void scatter(const ObservedBed& observed, const Values& values, MethodResult& result) {
  for (std::size_t k = 0; k < observed.seen.size(); ++k) {
    result.values.col(observed.seen[k]) = values.col(static_cast<Index>(k)).cwiseMax(0).cwiseMin(255);
    result.colored[static_cast<std::size_t>(observed.seen[k])] = 1;
  }
}

void colorByPreset(const ObservedBed& observed, Method method, const Params& params, MethodResult& result) {
  const ZOrderGrid grid = gridOf(observed.points);
  const Fused colors = colorPoints(observed.points, observed.observations, grid, method, params.graph, params.system);
  scatter(observed, colors.values, result);
}

void colorByGraph(const ObservedBed& observed, const std::string& method, const Params& params, MethodResult& result) {
  static const std::string kPlain = " plain";
  const bool plain = endsWith(method, kPlain);
  const std::string graph = plain ? method.substr(0, method.size() - kPlain.size()) : method;
  SystemParams system = params.system;
  system.min_data_weight = 0;  // as in the paper
  ProcessorWatch watch;
  const Fused mean = fuseMean(observed.observations);
  result.seconds = watch.lap();
  const GraphSolution solution = solveOnGraph(graph, observed.points, observed.observations, mean, system,
                                              plain ? Unanchored::kPlain : Unanchored::kAnchored);
  result.seconds += solution.seconds.total();  // without what is only a statistic
  scatter(observed, solution.values, result);
  result.edges_per_point =
      2 * static_cast<double>(solution.num_edges) / std::max(1.0, static_cast<double>(observed.points.cols()));
  result.unanchored_share = solution.unanchored_share;
}

void colorByDefault(const TestBed& bed, const Params& params, MethodResult& result) {
  const AlignmentResult aligned = alignBed(bed, params);
  std::vector<Eigen::Isometry3d> poses;
  std::vector<Exposure> exposures;
  std::vector<float> weights;
  for (const ViewAlignment& view : aligned.views) {
    poses.push_back(view.map_from_camera);
    exposures.push_back(view.exposure);
    weights.push_back(view.weight);
  }
  colorByPreset(observeBed(bed, poses, exposures, params, weights), Method::kDefault, params, result);
  result.reprojection_error = meanReprojectionError(bed, poses);
  result.gain_error = gainError(bed, exposures);
}

}  // namespace

std::vector<ObservedView> observedViews(const TestBed& bed, const Surfels& surfels, const Camera& camera,
                                        const std::vector<Eigen::Isometry3d>& poses,
                                        const std::vector<Exposure>& exposures, const std::vector<float>& weights,
                                        const Params& params) {
  std::vector<ObservedView> views(poses.size());
  parallelFor(params.colorize.num_threads, poses.size(), [&](std::size_t v) {
    views[v].id = static_cast<std::uint32_t>(v);
    views[v].camera = &camera;
    views[v].map_from_camera = poses[v];
    views[v].image = std::make_shared<const cv::Mat>(bed.images[v]);
    views[v].depth = depthOf(bed.points, surfels, camera, poses[v], params.depth);
    if (!exposures.empty()) views[v].exposure = exposures[v];
    if (!weights.empty()) views[v].weight = weights[v];
  });
  return views;
}

ObservedBed observeBed(const TestBed& bed, const std::vector<Eigen::Isometry3d>& poses,
                       const std::vector<Exposure>& exposures, const Params& params,
                       const std::vector<float>& weights) {
  ProcessorWatch watch;
  const Camera camera(bed.intrinsics);
  const Surfels surfels = estimateSurfels(bed.points, params.surfels);
  const auto views = observedViews(bed, surfels, camera, poses, exposures, weights, params);
  const auto view = [&](std::size_t v) { return views[v]; };
  ObserveResult seen = observe(bed.points, surfels, views.size(), view, params.depth, params.observe);
  ObservedBed observed;
  observed.stats = seen.stats;
  observed.observations = std::move(seen.observations);
  observed.seen = keepSeen(observed.observations);
  observed.points = gatherColumns(bed.points, observed.seen);
  observed.seconds = watch.lap();
  return observed;
}

Values seenTruth(const TestBed& bed, const ObservedBed& observed) {
  return gatherColumns(bed.truth, observed.seen);
}

std::vector<std::string> methodNames() {
  return {"closest", "mean",   "median", "5-NN plain", "5-NN",   "20-NN plain",   "20-NN",  "DT plain",
          "DT",      "1-pass", "2-pass", "3-pass",     "4-pass", "4-pass shared", "default"};
}

MethodResult colorizeArrays(const TestBed& bed, const ObservedBed& observed, const std::string& method,
                            const Params& params) {
  MethodResult result;
  result.values = Values::Zero(3, bed.points.cols());
  result.colored.assign(static_cast<std::size_t>(bed.points.cols()), 0);
  result.reprojection_error = meanReprojectionError(bed, bed.poses);
  result.gain_error = gainError(bed, std::vector<Exposure>(bed.poses.size()));
  ProcessorWatch watch;
  const std::vector<std::string> presets = enumNames(Method{});
  const auto preset = std::find(presets.begin(), presets.end(), method);
  if (method == "default") {
    colorByDefault(bed, params, result);
  } else if (preset != presets.end()) {
    colorByPreset(observed, static_cast<Method>(preset - presets.begin()), params, result);
  } else {
    colorByGraph(observed, method, params, result);
    return result;
  }
  result.seconds = watch.lap();
  return result;
}

}  // namespace cloud_colorizer
