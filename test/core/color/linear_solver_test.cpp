// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause
#include "cloud_colorizer/color/linear_solver.hpp"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <array>
#include <limits>
#include <utility>

#include "cloud_colorizer/color/system.hpp"

namespace cloud_colorizer {
namespace {

using Eigen::Index;

const std::array<SolverKind, 3> kSolvers{SolverKind::kConjugateGradients, SolverKind::kCholmod, SolverKind::kSpqr};

/// A band of 2001 points that only the anchor at its one end, if any, holds.
LinearSystem band(float anchor, float gradient) {
  std::vector<Edge> edges;
  for (std::uint32_t p = 0; p < 2000; ++p) {
    edges.push_back({p, p + 1});
    if (p + 7 <= 2000) edges.push_back({p, p + 7});
  }
  Eigen::VectorXf weights = Eigen::VectorXf::Zero(2001);
  weights(0) = anchor;
  const Values gradients = Values::Constant(1, static_cast<Index>(edges.size()), gradient);
  return assembleSystem(edges, gradients, Values::Ones(1, 2001), weights, 1);
}

Eigen::SparseMatrix<double> lowerOf(const Eigen::Matrix2d& matrix) {
  return Eigen::MatrixXd(matrix.triangularView<Eigen::Lower>()).sparseView();
}

TEST(LinearSolver, ComponentWithoutAnchorIsAnError) {
  const LinearSystem singular = band(0, 0), regular = band(1, 0);
  for (const SolverKind solver : {SolverKind::kCholmod, SolverKind::kSpqr}) {
    EXPECT_THROW(LinearSolver(singular.matrix, solver), std::runtime_error);
    const Eigen::MatrixXd ones = LinearSolver(regular.matrix, solver).solve(regular.rhs);
    EXPECT_LT((ones.array() - 1).abs().maxCoeff(), 1e-8);
  }
  const LinearSolver iterative(singular.matrix, SolverKind::kConjugateGradients);  // finds it while solving
  EXPECT_THROW(iterative.solve(Eigen::MatrixXd::Ones(2001, 1)), std::runtime_error);
}

TEST(LinearSolver, ConjugateGradientsReachTheFarEnd) {
  const LinearSystem system = band(1, 1);
  const Eigen::MatrixXd exact = LinearSolver(system.matrix, SolverKind::kCholmod).solve(system.rhs);
  const LinearSolver iterative(system.matrix, SolverKind::kConjugateGradients);
  EXPECT_LT((iterative.solve(system.rhs) - exact).cwiseAbs().maxCoeff(), 1e-3 * exact.cwiseAbs().maxCoeff());
  EXPECT_LT((iterative.solve(system.rhs, exact) - exact).norm(), 1e-9 * exact.norm());
}

TEST(LinearSolver, IndefiniteOrMalformedMatrixIsAnError) {
  constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
  const auto one = lowerOf(Eigen::Matrix2d::Identity());
  for (const SolverKind solver : kSolvers) {
    EXPECT_THROW(LinearSolver(lowerOf((Eigen::Matrix2d() << 1, 0, 0, kNan).finished()), solver), std::runtime_error);
    EXPECT_THROW(LinearSolver(Eigen::SparseMatrix<double>(2, 2), solver), std::runtime_error);
    EXPECT_THROW(LinearSolver(Eigen::SparseMatrix<double>(2, 3), solver), std::invalid_argument);
    if (solver == SolverKind::kSpqr) continue;  // it would take an indefinite matrix
    EXPECT_THROW(LinearSolver(lowerOf((Eigen::Matrix2d() << 1, 0, 0, -1).finished()), solver), std::runtime_error);
    EXPECT_THROW(
        LinearSolver(lowerOf((Eigen::Matrix2d() << 1, 2, 2, 1).finished()), solver).solve(Eigen::Vector2d(1, -1)),
        std::runtime_error);
  }
  EXPECT_NO_THROW(LinearSolver(one, SolverKind::kCholmod, {1, 0}));
  EXPECT_THROW(LinearSolver(one, SolverKind::kCholmod, {1, 1}), std::invalid_argument);
  EXPECT_THROW(LinearSolver(one, SolverKind::kCholmod, {1}), std::invalid_argument);
  EXPECT_THROW(LinearSolver(one, SolverKind::kCholmod, {0, 2}), std::invalid_argument);
}

TEST(LinearSolver, SolvesAnyNumberOfColumnsAndRefusesOtherSizes) {
  const Eigen::Matrix2d matrix = (Eigen::Matrix2d() << 2, -1, -1, 1).finished();
  for (const SolverKind kind : kSolvers) {
    LinearSolver first(lowerOf(matrix), kind);
    const LinearSolver solver = std::move(first);
    const double tolerance = kind == SolverKind::kConjugateGradients ? 1e-8 : 1e-12;
    const Eigen::MatrixXd right = Eigen::MatrixXd::Random(2, 9);
    EXPECT_LT((solver.solve(right) - matrix.inverse() * right).norm(), tolerance);
    EXPECT_LT((solver.solve(right, Eigen::MatrixXd::Random(2, 9)) - matrix.inverse() * right).norm(), tolerance);
    EXPECT_EQ(solver.solve(Eigen::MatrixXd::Zero(2, 1), Eigen::MatrixXd::Zero(2, 1)), Eigen::MatrixXd::Zero(2, 1));
    EXPECT_EQ(solver.solve(Eigen::MatrixXd(2, 0)).cols(), 0);
    EXPECT_THROW(solver.solve(Eigen::MatrixXd::Ones(3, 1)), std::invalid_argument);
    EXPECT_THROW(solver.solve(Eigen::MatrixXd::Ones(2, 2), Eigen::MatrixXd::Ones(2, 1)), std::invalid_argument);
    EXPECT_EQ(LinearSolver(Eigen::SparseMatrix<double>(0, 0), kind).solve(Eigen::MatrixXd(0, 3)).cols(), 3);
  }
}

}  // namespace
}  // namespace cloud_colorizer
