// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause

/// Micro-benchmarks of the stages, each on the points and images of a test bed: time a call, and points a second.
#include <benchmark/benchmark.h>

#include <map>

#include "cloud_colorizer/color/fuse.hpp"
#include "cloud_colorizer/color/system.hpp"
#include "evaluation/methods.hpp"

namespace cloud_colorizer {
namespace {

/// A graph with what is made of it.
struct GraphScene {
  OrderedGraph graph;
  Gradients gradients;
  Eigen::VectorXf data_weights;
  LinearSystem system;
};

/// Everything that the stages take, made once a size.
struct Scene {
  TestBed bed;
  Surfels surfels;
  ObservedBed observed;
  Fused mean;
  std::vector<std::uint64_t> keys;
  Eigen::MatrixXd guess;
  GraphScene own, shared;
};

OrderedGraph graphOf(const ObservedBed& observed, PassGrids grids) {
  GraphParams params;
  params.grids = grids;
  return orderedZorderGraph(observed.points, gridOf(observed.points), params);
}

GraphScene graphSceneOf(const ObservedBed& observed, const Fused& mean, PassGrids grids) {
  GraphScene scene;
  scene.graph = graphOf(observed, grids);
  scene.gradients = edgeGradients(scene.graph.edges, observed.observations, 0);
  scene.data_weights = dataWeights(observed.points, mean, scene.graph.edges, SystemParams{});
  scene.system = assembleSystem(scene.graph.edges, scene.gradients.values, mean.values, scene.data_weights, 1);
  return scene;
}

const Scene& sceneOf(std::int64_t num_points) {
  static std::map<std::int64_t, Scene> scenes;
  const auto known = scenes.find(num_points);
  if (known != scenes.end()) return known->second;
  TestBedParams params;
  params.num_points = static_cast<std::size_t>(num_points);
  params.num_views = 12;
  Scene& scene = scenes[num_points];
  scene.bed = addNoise(renderTestBed(bumpySphere(), params), NoiseParams{}, 1);
  scene.surfels = estimateSurfels(scene.bed.points, SurfelParams{});
  scene.observed = observeBed(scene.bed, scene.bed.poses, {}, Params{});
  const ObservedBed& o = scene.observed;
  scene.mean = fuseMean(o.observations);
  scene.keys = zorderKeys(o.points, gridOf(o.points));
  scene.own = graphSceneOf(o, scene.mean, PassGrids::kOwn);
  scene.shared = graphSceneOf(o, scene.mean, PassGrids::kShared);
  scene.guess = scene.mean.values.transpose().cast<double>();
  return scene;
}

template <class Stage>
void measure(benchmark::State& state, const Stage& stage) {
  const Scene& scene = sceneOf(state.range(0));
  for (auto _ : state) benchmark::DoNotOptimize(stage(scene));
  state.SetItemsProcessed(state.iterations() * state.range(0));
}

void zorderKeysOf(benchmark::State& state) {
  measure(state, [](const Scene& s) { return zorderKeys(s.observed.points, gridOf(s.observed.points)); });
}
void zorderSortOf(benchmark::State& state) {
  measure(state, [](const Scene& s) { return zorderSort(s.keys, zorderMask(1)); });
}
void edges(benchmark::State& state) {
  measure(state, [](const Scene& s) { return graphOf(s.observed, PassGrids::kOwn).edges.size(); });
}
void surfels(benchmark::State& state) {
  measure(state, [](const Scene& s) { return estimateSurfels(s.bed.points, SurfelParams{}).radii.sum(); });
}
void depthImage(benchmark::State& state) {
  measure(state, [](const Scene& s) {
    const Camera camera(s.bed.intrinsics);
    DepthSplatter splatter(camera, s.bed.poses[0].inverse().cast<float>(), DepthParams{});
    splatter.add(s.bed.points, s.surfels);
    return splatter.finish().depth.rows;
  });
}
void observation(benchmark::State& state) {
  measure(state, [](const Scene& s) { return observeBed(s.bed, s.bed.poses, {}, Params{}).seen.size(); });
}
void fusingRobust(benchmark::State& state) {
  measure(state, [](const Scene& s) { return fuseRobust(s.observed.observations, 6).values.sum(); });
}
void gradientsOf(benchmark::State& state) {
  measure(state, [](const Scene& s) {
    return edgeGradients(s.own.graph.edges, s.observed.observations, 0).has_evidence.size();
  });
}
void assembly(benchmark::State& state) {
  measure(state, [](const Scene& s) {
    return assembleSystem(s.own.graph.edges, s.own.gradients.values, s.mean.values, s.own.data_weights, 1)
        .matrix.nonZeros();
  });
}
void conjugateGradients(benchmark::State& state) {
  measure(state, [](const Scene& s) {
    return LinearSolver(s.own.system.matrix, SolverKind::kConjugateGradients).solve(s.own.system.rhs, s.guess).sum();
  });
}
void sharedEdges(benchmark::State& state) {
  measure(state, [](const Scene& s) { return graphOf(s.observed, PassGrids::kShared).edges.size(); });
}
void sharedFactor(benchmark::State& state) {
  measure(state, [](const Scene& s) {
    return LinearSolver(s.shared.system.matrix, SolverKind::kCholmod, s.shared.graph.elimination_order);
  });
}
void sharedSolve(benchmark::State& state) {
  const Scene& scene = sceneOf(state.range(0));
  const LinearSolver solver(scene.shared.system.matrix, SolverKind::kCholmod, scene.shared.graph.elimination_order);
  for (auto _ : state) benchmark::DoNotOptimize(solver.solve(scene.shared.system.rhs).sum());
  state.SetItemsProcessed(state.iterations() * state.range(0));
}

constexpr int kPoints = 200000;
BENCHMARK(zorderKeysOf)->Arg(kPoints)->Unit(benchmark::kMillisecond);
BENCHMARK(zorderSortOf)->Arg(kPoints)->Unit(benchmark::kMillisecond);
BENCHMARK(edges)->Arg(kPoints)->Unit(benchmark::kMillisecond);
BENCHMARK(surfels)->Arg(kPoints)->Unit(benchmark::kMillisecond);
BENCHMARK(depthImage)->Arg(kPoints)->Unit(benchmark::kMillisecond);
BENCHMARK(observation)->Arg(kPoints)->Unit(benchmark::kMillisecond);
BENCHMARK(fusingRobust)->Arg(kPoints)->Unit(benchmark::kMillisecond);
BENCHMARK(gradientsOf)->Arg(kPoints)->Unit(benchmark::kMillisecond);
BENCHMARK(assembly)->Arg(kPoints)->Unit(benchmark::kMillisecond);
BENCHMARK(conjugateGradients)->Arg(kPoints)->Unit(benchmark::kMillisecond);
BENCHMARK(sharedEdges)->Arg(kPoints)->Unit(benchmark::kMillisecond);
BENCHMARK(sharedFactor)->Arg(kPoints)->Unit(benchmark::kMillisecond);
BENCHMARK(sharedSolve)->Arg(kPoints)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace cloud_colorizer

BENCHMARK_MAIN();
