// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause
#include "cloud_colorizer/color/system.hpp"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <array>
#include <cmath>
#include <limits>
#include <random>

#include "color/solve.hpp"

namespace cloud_colorizer {
namespace {

using Eigen::Index;

const ZOrderGrid kGrid{Eigen::Vector3f::Constant(-2), 0.001F};
const std::array<SolverKind, 3> kSolvers{SolverKind::kConjugateGradients, SolverKind::kCholmod, SolverKind::kSpqr};

struct Scene {
  Points points;
  Observations observations;
};

/// Points on a sphere; point p in view i has the value texture(p) + noise * error(p, i).
Scene makeScene(int num_points, float noise) {
  std::mt19937 random(4);
  std::normal_distribution<float> normal;
  Scene scene;
  scene.points.resize(3, num_points);
  scene.observations.offsets.push_back(0);
  std::vector<Eigen::Vector3f> values;
  for (int p = 0; p < num_points; ++p) {
    const Eigen::Vector3f point = Eigen::Vector3f(normal(random), normal(random), normal(random)).normalized();
    scene.points.col(p) = point;
    for (std::uint32_t view = 0; view < 8; ++view) {
      if (point(view % 3) * (view < 4 ? 1.0F : -1.0F) < 0.1F && view != static_cast<std::uint32_t>(p % 8)) continue;
      scene.observations.views.push_back(view);
      scene.observations.distances.push_back(1.0F + 0.1F * static_cast<float>(view) + 0.01F * point(1));
      scene.observations.weights.push_back(1);
      values.push_back(100 * point.cwiseAbs() + noise * Eigen::Vector3f(normal(random), normal(random), 1));
    }
    scene.observations.offsets.push_back(static_cast<std::uint32_t>(values.size()));
  }
  scene.observations.values = Eigen::Map<const Values>(values.data()->data(), 3, static_cast<Index>(values.size()));
  return scene;
}

/// E of eq. (1) for one channel, straight from its definition.
double energy(const Eigen::VectorXd& c, const std::vector<Edge>& edges, const Eigen::VectorXf& gradients,
              const Eigen::VectorXf& data, const Eigen::VectorXf& weights, double lambda) {
  double sum = 0;
  for (Index p = 0; p < c.size(); ++p) sum += weights(p) * std::pow(c(p) - data(p), 2);
  for (std::size_t e = 0; e < edges.size(); ++e) {
    sum += lambda * edges[e].weight * std::pow(c(edges[e].p) - c(edges[e].q) - gradients(static_cast<Index>(e)), 2);
  }
  return sum;
}

TEST(System, SolutionMinimisesTheEnergy) {
  const std::vector<Edge> edges = {{0, 1, 1}, {0, 3, 0.5F}, {1, 2, 0.3F}, {2, 4, 0}, {3, 4, 1}};
  const Values gradients = 50 * Values::Random(2, 5), data = 100 * Values::Random(2, 5);
  Eigen::VectorXf weights(5);
  weights << 1, 0, 0.01F, 0, 1;
  const double lambda = 0.7;
  const LinearSystem system = assembleSystem(edges, gradients, data, weights, lambda);
  for (const SolverKind solver : kSolvers) {
    const Eigen::MatrixXd solution = LinearSolver(system.matrix, solver).solve(system.rhs);
    for (Index channel = 0; channel < 2; ++channel) {
      const Eigen::VectorXf g = gradients.row(channel), d = data.row(channel);
      const auto e = [&](const Eigen::VectorXd& c) { return energy(c, edges, g, d, weights, lambda); };
      const Eigen::MatrixXd unit = Eigen::MatrixXd::Identity(5, 5);
      const double at_zero = e(Eigen::VectorXd::Zero(5));
      Eigen::MatrixXd hessian(5, 5);  // differences are exact, as E is quadratic
      Eigen::VectorXd slope(5);
      for (Index i = 0; i < 5; ++i) {
        slope(i) = (e(unit.col(i)) - e(-unit.col(i))) / 2;
        for (Index j = 0; j < 5; ++j) {
          hessian(i, j) = e(unit.col(i) + unit.col(j)) - e(unit.col(i)) - e(unit.col(j)) + at_zero;
        }
      }
      const Eigen::VectorXd expected = hessian.ldlt().solve(-slope);
      EXPECT_LT((solution.col(channel) - expected).cwiseAbs().maxCoeff(), 1e-6);
    }
  }
}

TEST(System, GradientPointsFromQToP) {
  Observations o;  // views 1 and 4 in common; view 2 only at p, view 3 only at q
  o.offsets = {0, 3, 6};
  o.views = {1, 2, 4, 1, 3, 4};
  o.distances = {1, 1, 5, 1, 1, 1};
  o.weights = std::vector<float>(6, 1.0F);
  o.values.resize(1, 6);
  o.values << 10, 99, 20, 7, 55, 12;
  EXPECT_FLOAT_EQ(edgeGradients({{0, 1}}, o, 0).values(0, 0), 5.5F);  // mean of 3 and 8
  EXPECT_FLOAT_EQ(edgeGradients({{0, 1}}, o, 2.0).values(0, 0), 3);   // view 4 is far from p
  EXPECT_EQ(edgeGradients({{0, 1}}, o, 0.5).has_evidence.at(0), 0);   // all are far
  Eigen::VectorXf weights(6);
  weights << 1, 1, 0.5F, 0.5F, 1, 1;
  EXPECT_FLOAT_EQ(edgeGradients({{0, 1}}, o, 0, weights).values(0, 0), 5.5F);  // 0.5 each
  weights(2) = 0;
  EXPECT_FLOAT_EQ(edgeGradients({{0, 1}}, o, 0, weights).values(0, 0), 3);
  EXPECT_EQ(edgeGradients({{0, 1}}, o, 0, Eigen::VectorXf::Zero(6)).has_evidence.at(0), 0);
}

TEST(System, EdgeWithoutCommonViewIsWeakOrDropped) {
  Observations o;
  o.offsets = {0, 1, 2};
  o.views = {0, 1};
  o.distances = o.weights = {1, 1};
  o.values = Values::Constant(1, 2, 50);
  const Gradients gradients = edgeGradients({{0, 1}}, o, 0);
  EXPECT_EQ(gradients.has_evidence.at(0), 0);
  EXPECT_EQ(gradients.values(0, 0), 0);
  EXPECT_FLOAT_EQ(weighEvidence({{0, 1, 0.5F}}, gradients, 0.01).at(0).weight, 0.005F);
  const auto dropped = weighEvidence({{0, 1}}, gradients, 0);
  EXPECT_EQ(assembleSystem(dropped, gradients.values, Values::Zero(1, 2), Eigen::Vector2f::Ones(), 1).matrix.nonZeros(),
            2);
}

TEST(Solve, ConsistentViewsAreReproduced) {
  const Scene scene = makeScene(800, 0);
  for (const auto anchors : {AnchorKind::kRandom, AnchorKind::kConsistent}) {
    for (const double no_evidence_weight : {0.0, 1e-9}) {
      SystemParams params;
      params.anchors = anchors;
      params.min_data_weight = 0;
      params.no_evidence_weight = no_evidence_weight;  // 0: components, each with its anchor
      const Fused data = fuseMean(scene.observations);
      const Values solution = solveValues(scene.points, scene.observations, data, kGrid, {}, params);
      EXPECT_LT((solution - data.values).cwiseAbs().maxCoeff(), 0.01);
    }
  }
}

TEST(Solve, SolversAgree) {
  const Scene scene = makeScene(1500, 10);
  const Fused data = fuseRobust(scene.observations, 2);
  const OrderedGraph graph = orderedZorderGraph(scene.points, kGrid, {4, PassGrids::kShared});
  const auto gradients = edgeGradients(graph.edges, scene.observations, 0, data.observation_weights);
  const auto weights = dataWeights(scene.points, data, graph.edges, {});
  const auto system = assembleSystem(graph.edges, gradients.values, data.values, weights, 1);
  const Eigen::MatrixXd a = LinearSolver(system.matrix, SolverKind::kCholmod).solve(system.rhs);
  const Eigen::MatrixXd b = LinearSolver(system.matrix, SolverKind::kSpqr).solve(system.rhs);
  EXPECT_LT((a - b).cwiseAbs().maxCoeff(), 1e-8);
  const Eigen::MatrixXd c =
      LinearSolver(system.matrix, SolverKind::kCholmod, graph.elimination_order).solve(system.rhs);
  EXPECT_LT((a - c).cwiseAbs().maxCoeff(), 1e-8);
  const Eigen::MatrixXd d = LinearSolver(system.matrix, SolverKind::kConjugateGradients).solve(system.rhs);
  EXPECT_LT((a - d).cwiseAbs().maxCoeff(), 0.005);
  const Eigen::MatrixXd residual = system.matrix.selfadjointView<Eigen::Lower>() * a - system.rhs;
  EXPECT_LT(residual.cwiseAbs().maxCoeff(), 1e-9);
}

/// Parameters that spread the colours far make the system hard for conjugate gradients.
TEST(Solve, ConjugateGradientsConvergeForExtremeParameters) {
  const Scene scene = makeScene(2000, 10);
  const Fused data = fuseMean(scene.observations);
  for (const double lambda : {1e-6, 100.0, 1e6}) {
    for (const double anchor_share : {0.0, 0.001, 1.0}) {
      SystemParams params;
      params.lambda = lambda;
      params.anchor_share = anchor_share;
      params.min_data_weight = 0;
      const GraphParams graph{4, PassGrids::kShared};
      const Values a = solveValues(scene.points, scene.observations, data, kGrid, graph, params);
      params.solver = SolverKind::kCholmod;
      const Values b = solveValues(scene.points, scene.observations, data, kGrid, graph, params);
      EXPECT_LT((a - b).cwiseAbs().maxCoeff(), 0.05) << lambda << " " << anchor_share;
    }
  }
}

TEST(Solve, GridsFollowTheSolverUnlessTold) {
  const Scene scene = makeScene(500, 10);
  const Fused data = fuseMean(scene.observations);
  const auto solve = [&](SolverKind solver, PassGrids grids) {
    SystemParams params;
    params.solver = solver;
    return solveValues(scene.points, scene.observations, data, kGrid, {4, grids}, params);
  };
  for (const auto& [solver, grids] :
       {std::pair(SolverKind::kConjugateGradients, PassGrids::kOwn),
        std::pair(SolverKind::kCholmod, PassGrids::kShared), std::pair(SolverKind::kSpqr, PassGrids::kShared)}) {
    EXPECT_EQ(solve(solver, PassGrids::kAuto), solve(solver, grids));
  }
  EXPECT_NE(solve(SolverKind::kCholmod, PassGrids::kOwn), solve(SolverKind::kCholmod, PassGrids::kShared));
}

TEST(DataWeights, ChunksDrawTheSameRandomAnchors) {
  const Scene scene = makeScene(5000, 10);
  const SystemParams params;
  const Fused all = fuseMean(scene.observations);
  Fused half = all;
  half.count = all.count.tail(2500).eval();
  half.stddev = all.stddev.tail(2500).eval();
  const std::vector<Edge> chain = zorderGraph(scene.points, kGrid, {});
  const auto weights = dataWeights(scene.points, all, chain, params);
  const Points tail = scene.points.rightCols(2500);
  const auto tail_weights = dataWeights(tail, half, zorderGraph(tail, kGrid, {}), params);
  EXPECT_EQ(tail_weights.tail(2495), weights.tail(2495));  // those nearer to the border miss points to compare with
  EXPECT_EQ((weights.array() == 1e-3F).count(), 5000 - (weights.array() == 1).count());
}

TEST(DataWeights, RandomAnchorsAreTheShareAskedForAndSpread) {
  const Scene scene = makeScene(20000, 10);
  const Fused data = fuseMean(scene.observations);
  const std::vector<Edge> chain = zorderGraph(scene.points, kGrid, {});
  for (const double share : {1.0, 0.75, 0.5, 0.3, 0.1, 0.01}) {
    SystemParams params;
    params.anchor_share = share;
    const auto weights = dataWeights(scene.points, data, chain, params);
    // Lots drawn point by point would deviate by sqrt(n share (1 - share)); these deviate by less.
    const double deviation = std::sqrt(20000 * share * (1 - share));
    EXPECT_NEAR(static_cast<double>((weights.array() == 1).count()), 20000 * share, 2 * deviation) << share;
    const Index apart = static_cast<Index>(1 / share - 1) / 2 + 1;  // nearer anchors would have compared their lots
    Index last = -apart;
    for (Index p = 0; p < weights.size(); ++p) {
      if (weights(p) != 1) continue;
      EXPECT_GE(p - last, apart) << share;
      last = p;
    }
  }
}

TEST(DataWeights, ATinyShareIsOneAnchorAndNoneIsOneForTheComponent) {
  const Scene scene = makeScene(1000, 10);
  const Fused data = fuseMean(scene.observations);
  for (const double share : {0.0, 1e-300, 1e-9}) {
    SystemParams params;
    params.anchor_share = share;
    const auto weights = dataWeights(scene.points, data, zorderGraph(scene.points, kGrid, {}), params);
    EXPECT_EQ((weights.array() == 1).count(), 1) << share;
  }
}

TEST(DataWeights, ConsistentAnchorsHaveTheLeastStddev) {
  const Scene scene = makeScene(1000, 10);
  const Fused data = fuseMean(scene.observations);
  SystemParams params;
  params.anchors = AnchorKind::kConsistent;
  const auto weights = dataWeights(scene.points, data, zorderGraph(scene.points, kGrid, {}), params);
  EXPECT_EQ((weights.array() == 1).count(), 100);
  float worst_anchor = 0, best_other = 1e9F;
  for (Index p = 0; p < 1000; ++p) {
    if (weights(p) == 1) {
      EXPECT_GE(data.count(p), 2);
      worst_anchor = std::max(worst_anchor, data.stddev(p));
    } else if (data.count(p) >= 2) {
      best_other = std::min(best_other, data.stddev(p));
    }
  }
  EXPECT_LE(worst_anchor, best_other);
}

TEST(DataWeights, EveryComponentHasAnAnchor) {
  Fused fused;
  fused.count = (Eigen::VectorXi(6) << 1, 3, 3, 2, 0, 1).finished();
  fused.stddev = Eigen::VectorXf::Zero(6);
  SystemParams params;
  params.anchor_share = 0;
  const Points points = Points::Random(3, 6);
  const Eigen::VectorXf weights = dataWeights(points, fused, {{0, 1}, {1, 2}, {3, 4}}, params);
  EXPECT_EQ(weights, (Eigen::VectorXf(6) << 1e-3F, 1, 1e-3F, 1, 0, 1).finished());
}

TEST(System, BadInputIsRefused) {
  const Scene scene = makeScene(10, 0);
  EXPECT_THROW(edgeGradients({{0, 10}}, scene.observations, 0), std::invalid_argument);
  EXPECT_THROW(edgeGradients({{0, 1}}, scene.observations, 0, Eigen::VectorXf::Ones(1)), std::invalid_argument);
  EXPECT_THROW(weighEvidence({{0, 1}}, {}, 1), std::invalid_argument);
  const Values two = Values::Zero(1, 2), three = Values::Zero(1, 3);
  const Eigen::Vector3f weights = Eigen::Vector3f::Ones();
  EXPECT_THROW(assembleSystem({{1, 2}, {0, 1}}, two, three, weights, 1), std::invalid_argument);
  EXPECT_THROW(assembleSystem({{0, 1}, {0, 1}}, two, three, weights, 1), std::invalid_argument);
  EXPECT_THROW(assembleSystem({{0, 1}}, two, three, weights, 1), std::invalid_argument);
  EXPECT_THROW(assembleSystem({}, Values(1, 0), three, Eigen::Vector2f::Ones(), 1), std::invalid_argument);
  EXPECT_THROW(dataWeights(scene.points, Fused{}, {}, {}), std::invalid_argument);
  SystemParams params;
  params.lambda = 0;
  EXPECT_THROW(params.check(), std::invalid_argument);
  params = {};
  params.anchor_share = NAN;
  EXPECT_THROW(params.check(), std::invalid_argument);
}

TEST(Solve, UnseenPointIsRefused) {
  Scene scene = makeScene(10, 0);
  scene.points.conservativeResize(3, 11);
  scene.points.col(10).setZero();
  const Fused data = fuseMean(scene.observations);
  EXPECT_THROW(solveValues(scene.points, scene.observations, data, kGrid, {}, {}), std::invalid_argument);
  scene.observations.offsets.push_back(scene.observations.offsets.back());
  const Fused unseen = fuseMean(scene.observations);
  EXPECT_THROW(solveValues(scene.points, scene.observations, unseen, kGrid, {}, {}), std::invalid_argument);
}

TEST(Solve, NoPointsGiveNoValuesAndOnePointItsOwn) {
  EXPECT_EQ(solveValues(Points(3, 0), {}, fuseMean({}), kGrid, {}, {}).cols(), 0);
  const Scene scene = makeScene(1, 5);
  const Fused data = fuseMean(scene.observations);
  for (const SolverKind solver : {SolverKind::kCholmod, SolverKind::kSpqr}) {
    SystemParams params;
    params.solver = solver;
    EXPECT_TRUE(solveValues(scene.points, scene.observations, data, kGrid, {}, params).isApprox(data.values));
  }
}

}  // namespace
}  // namespace cloud_colorizer
