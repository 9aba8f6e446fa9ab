// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause

/// Micro-benchmarks of the stages, one row each, on the points and images of a test bed. Time is by the clock on the
/// wall, CPU that of all threads; the counters tell the time on the wall for one point, point and view, observation or
/// edge.
#include <benchmark/benchmark.h>
#include <pcl/features/normal_3d.h>
#include <pcl/kdtree/kdtree_flann.h>
#include <pcl/search/kdtree.h>

#include <Eigen/IterativeLinearSolvers>
#include <array>
#include <map>

#include "cloud_colorizer/color/fuse.hpp"
#include "cloud_colorizer/color/system.hpp"
#include "core/pcl_points.hpp"
#include "evaluation/methods.hpp"
#include "surface/kdtree.hpp"
#include "visibility/best_views.hpp"

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
  Camera camera;
  Surfels surfels;
  std::vector<ObservedView> views;
  ObservedBed observed;
  Fused mean;
  std::vector<std::uint64_t> keys;
  Eigen::MatrixXd guess, exact;  ///< of the system of `own`
  GraphScene own, shared;

  double numPoints() const { return static_cast<double>(bed.points.cols()); }
  double numPointViews() const { return numPoints() * static_cast<double>(views.size()); }
  double numObservations() const { return static_cast<double>(observed.observations.views.size()); }
  double numEdges() const { return static_cast<double>(own.graph.edges.size()); }
};

/// With it Eigen's solver ends about as near to the exact solution as ours does.
constexpr double kEigenTolerance = 1e-5;
using EigenSolver =
    Eigen::ConjugateGradient<Eigen::SparseMatrix<double>, Eigen::Lower, Eigen::IncompleteCholesky<double>>;

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

Eigen::MatrixXd solveByEigen(const LinearSystem& system, const Eigen::MatrixXd& guess, double tolerance) {
  EigenSolver solver;
  solver.setTolerance(tolerance);
  solver.compute(system.matrix);
  return solver.solveWithGuess(system.rhs, guess);
}

const Scene& sceneOf(std::int64_t num_points) {
  static std::map<std::int64_t, Scene> scenes;
  const auto known = scenes.find(num_points);
  if (known != scenes.end()) return known->second;
  TestBedParams params;
  params.num_points = static_cast<std::size_t>(num_points);
  params.num_views = 12;
  const TestBed bed = noisyBed(bumpySphere(), params, NoiseParams{});
  Scene& scene =
      scenes.emplace(num_points, Scene{bed, Camera(bed.intrinsics), {}, {}, {}, {}, {}, {}, {}, {}, {}}).first->second;
  scene.surfels = estimateSurfels(bed.points, SurfelParams{});
  scene.views = observedViews(scene.bed, scene.surfels, scene.camera, bed.poses, {}, {}, Params{});
  scene.observed = observeBed(bed, bed.poses, {}, Params{});
  const ObservedBed& o = scene.observed;
  scene.mean = fuseMean(o.observations);
  scene.keys = zorderKeys(o.points, gridOf(o.points));
  scene.own = graphSceneOf(o, scene.mean, PassGrids::kOwn);
  scene.shared = graphSceneOf(o, scene.mean, PassGrids::kShared);
  scene.guess = scene.mean.values.transpose().cast<double>();
  scene.exact = solveByEigen(scene.own.system, scene.guess, 1e-13);
  return scene;
}

/// Runs `stage(scene)`; `count(scene)` is how many of what `counter` names it works on.
template <class Stage>
void measure(benchmark::State& state, const char* counter, double (Scene::*count)() const, const Stage& stage) {
  const Scene& scene = sceneOf(state.range(0));
  for (auto _ : state) benchmark::DoNotOptimize(stage(scene));
  const double items = (scene.*count)() * static_cast<double>(state.iterations());
  state.counters[counter] = benchmark::Counter(items, benchmark::Counter::kIsRate | benchmark::Counter::kInvert);
}

template <class Stage>
void measurePoints(benchmark::State& state, const Stage& stage) {
  measure(state, "per_point", &Scene::numPoints, stage);
}

/// How far from the exact solution, as a share of it (root mean square).
void tellError(benchmark::State& state, const Eigen::MatrixXd& solution) {
  const Eigen::MatrixXd& exact = sceneOf(state.range(0)).exact;
  state.counters["error"] = (solution - exact).norm() / exact.norm();
}

void zorderKeysOf(benchmark::State& state) {
  measurePoints(state, [](const Scene& s) { return zorderKeys(s.observed.points, gridOf(s.observed.points)); });
}
void zorderSortOf(benchmark::State& state) {
  measurePoints(state, [](const Scene& s) { return zorderSort(s.keys, zorderMask(1)); });
}
void edges(benchmark::State& state) {
  measurePoints(state, [](const Scene& s) { return graphOf(s.observed, PassGrids::kOwn).edges.size(); });
}
void sharedEdges(benchmark::State& state) {
  measurePoints(state, [](const Scene& s) { return graphOf(s.observed, PassGrids::kShared).edges.size(); });
}
void surfels(benchmark::State& state) {
  measurePoints(state, [](const Scene& s) { return estimateSurfels(s.bed.points, SurfelParams{}).radii.sum(); });
}
/// The neighbours that surfels are made of, by our tree and by PCL's, and PCL's normals.
void neighbors(benchmark::State& state) {
  measurePoints(state, [](const Scene& s) {
    const KdTree tree(s.bed.points);
    std::array<std::uint32_t, 16> indices;
    std::array<float, 16> squared;
    float sum = 0;
    for (Eigen::Index i = 0; i < s.bed.points.cols(); ++i, sum += squared.back()) {
      tree.nearest(s.bed.points.col(i), squared.size(), indices.data(), squared.data());
    }
    return sum;
  });
}
void pclNeighbors(benchmark::State& state) {
  measurePoints(state, [cloud = test::pclPoints(sceneOf(state.range(0)).bed.points)](const Scene&) {
    pcl::KdTreeFLANN<pcl::PointXYZ> tree;
    tree.setInputCloud(cloud);
    std::vector<int> indices(16);
    std::vector<float> squared(16);
    float sum = 0;
    for (int i = 0; i < static_cast<int>(cloud->size()); ++i, sum += squared.back()) {
      tree.nearestKSearch(i, 16, indices, squared);
    }
    return sum;
  });
}
void pclNormals(benchmark::State& state) {
  measurePoints(state, [cloud = test::pclPoints(sceneOf(state.range(0)).bed.points)](const Scene&) {
    pcl::NormalEstimation<pcl::PointXYZ, pcl::Normal> estimation;
    estimation.setInputCloud(cloud);
    estimation.setSearchMethod(pcl::search::KdTree<pcl::PointXYZ>::Ptr(new pcl::search::KdTree<pcl::PointXYZ>));
    estimation.setKSearch(16);
    pcl::PointCloud<pcl::Normal> normals;
    estimation.compute(normals);
    return normals.size();
  });
}
/// One view.
void depthImage(benchmark::State& state) {
  measurePoints(state, [](const Scene& s) {
    DepthSplatter splatter(s.camera, s.bed.poses[0].inverse().cast<float>(), DepthParams{});
    splatter.add(s.bed.points, s.surfels);
    return splatter.finish().depth.rows;
  });
}
/// All views, with the surfels and depth images that are there.
void observeOnly(benchmark::State& state) {
  measure(state, "per_point_view", &Scene::numPointViews, [](const Scene& s) {
    const auto view = [&](std::size_t v) { return s.views[v]; };
    return observe(s.bed.points, s.surfels, s.views.size(), view, DepthParams{}, ObserveParams{}).unseen.size();
  });
}
/// The observations put into the lists of their points, view by view, and taken out again.
void lists(benchmark::State& state) {
  measure(state, "per_observation", &Scene::numObservations, [](const Scene& s) {
    const Observations& o = s.observed.observations;
    BestViews best(o.numPoints(), ObserveParams{}.max_views);
    best.reserve(s.views.size(), 3);
    std::vector<std::uint32_t> next = o.offsets;
    for (std::uint32_t v = 0; v < s.views.size(); ++v) {
      for (std::size_t p = 0; p < o.numPoints(); ++p) {
        const std::uint32_t k = next[p];
        if (k == o.offsets[p + 1] || o.views[k] != v) continue;
        best.add(p, {v, o.distances[k], o.weights[k]}, o.values.col(k).data(), false);
        ++next[p];
      }
    }
    return best.finish().views.size();
  });
}
void fusingMean(benchmark::State& state) {
  measure(state, "per_observation", &Scene::numObservations,
          [](const Scene& s) { return fuseMean(s.observed.observations).values.sum(); });
}
void fusingRobust(benchmark::State& state) {
  measure(state, "per_observation", &Scene::numObservations,
          [](const Scene& s) { return fuseRobust(s.observed.observations, 6).values.sum(); });
}
void gradientsOf(benchmark::State& state) {
  measure(state, "per_edge", &Scene::numEdges, [](const Scene& s) {
    return edgeGradients(s.own.graph.edges, s.observed.observations, 0).has_evidence.size();
  });
}
void dataWeightsOf(benchmark::State& state) {
  measurePoints(state, [](const Scene& s) {
    return dataWeights(s.observed.points, s.mean, s.own.graph.edges, SystemParams{}).sum();
  });
}
void assembly(benchmark::State& state) {
  measure(state, "per_edge", &Scene::numEdges, [](const Scene& s) {
    return assembleSystem(s.own.graph.edges, s.own.gradients.values, s.mean.values, s.own.data_weights, 1)
        .matrix.nonZeros();
  });
}
void conjugateGradients(benchmark::State& state) {
  Eigen::MatrixXd solution;
  measurePoints(state, [&](const Scene& s) {
    solution = LinearSolver(s.own.system.matrix, SolverKind::kConjugateGradients).solve(s.own.system.rhs, s.guess);
    return solution.data();
  });
  tellError(state, solution);
}
void eigenConjugateGradients(benchmark::State& state) {
  Eigen::MatrixXd solution;
  measurePoints(state, [&](const Scene& s) {
    solution = solveByEigen(s.own.system, s.guess, kEigenTolerance);
    return solution.data();
  });
  tellError(state, solution);
}
void sharedFactor(benchmark::State& state) {
  measurePoints(state, [](const Scene& s) {
    return LinearSolver(s.shared.system.matrix, SolverKind::kCholmod, s.shared.graph.elimination_order);
  });
}
void sharedSolve(benchmark::State& state) {
  const Scene& scene = sceneOf(state.range(0));
  const LinearSolver solver(scene.shared.system.matrix, SolverKind::kCholmod, scene.shared.graph.elimination_order);
  measurePoints(state, [&](const Scene& s) { return solver.solve(s.shared.system.rhs).sum(); });
}

void inMilliseconds(benchmark::internal::Benchmark* row) {
  constexpr int kPoints = 200000;
  row->Arg(kPoints)->Unit(benchmark::kMillisecond)->MeasureProcessCPUTime()->UseRealTime();
}
BENCHMARK(zorderKeysOf)->Apply(inMilliseconds);
BENCHMARK(zorderSortOf)->Apply(inMilliseconds);
BENCHMARK(edges)->Apply(inMilliseconds);
BENCHMARK(surfels)->Apply(inMilliseconds);
BENCHMARK(neighbors)->Apply(inMilliseconds);
BENCHMARK(pclNeighbors)->Apply(inMilliseconds);
BENCHMARK(pclNormals)->Apply(inMilliseconds);
BENCHMARK(depthImage)->Apply(inMilliseconds);
BENCHMARK(observeOnly)->Apply(inMilliseconds);
BENCHMARK(lists)->Apply(inMilliseconds);
BENCHMARK(fusingMean)->Apply(inMilliseconds);
BENCHMARK(fusingRobust)->Apply(inMilliseconds);
BENCHMARK(gradientsOf)->Apply(inMilliseconds);
BENCHMARK(dataWeightsOf)->Apply(inMilliseconds);
BENCHMARK(assembly)->Apply(inMilliseconds);
BENCHMARK(conjugateGradients)->Apply(inMilliseconds);
BENCHMARK(eigenConjugateGradients)->Apply(inMilliseconds);
BENCHMARK(sharedEdges)->Apply(inMilliseconds);
BENCHMARK(sharedFactor)->Apply(inMilliseconds);
BENCHMARK(sharedSolve)->Apply(inMilliseconds);

}  // namespace
}  // namespace cloud_colorizer

BENCHMARK_MAIN();
