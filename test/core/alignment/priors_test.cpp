// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "alignment/pose_system.hpp"

namespace cloud_colorizer::alignment {
namespace {

constexpr std::size_t kViews = 60;

/// Views of two cameras in turn, 0.1 s apart, and one photograph long after.
AlignmentInput driveInput() {
  AlignmentInput input;
  Intrinsics intrinsics;
  intrinsics.width = 100, intrinsics.height = 80;
  intrinsics.fx = intrinsics.fy = 90, intrinsics.cx = 50, intrinsics.cy = 40;
  input.cameras = {Camera(intrinsics), Camera(intrinsics)};
  for (std::size_t v = 0; v < kViews; ++v) {
    View view;
    view.camera = v % 2;
    view.stamp = 0.05 * static_cast<double>(v);
    view.map_from_camera.pretranslate(Eigen::Vector3d(0.5 * static_cast<double>(v), 0, 0));
    input.views.push_back(view);
  }
  View photograph;
  photograph.stamp = 100;
  input.views.push_back(photograph);
  return input;
}

PosePriors drivePriors(const AlignmentInput& input) {
  return makePriors(input, AlignmentParams{}, std::vector<double>(input.views.size(), 10));
}

PoseState zeroState(const AlignmentInput& input) {
  return {std::vector<Twist>(input.views.size(), Twist::Zero()), std::vector<Twist>(2, Twist::Zero()), {0, 0}};
}

TEST(AlignmentPriors, PreviousIsTheLastViewOfTheSameCameraUnlessItIsLongAgo) {
  const AlignmentInput input = driveInput();
  const PosePriors priors = drivePriors(input);
  ASSERT_EQ(priors.previous.size(), kViews + 1);
  EXPECT_EQ(priors.previous[0], 0U);
  EXPECT_EQ(priors.previous[1], 1U);
  EXPECT_EQ(priors.previous[2], 0U);
  EXPECT_EQ(priors.previous[kViews - 1], kViews - 3);
  EXPECT_EQ(priors.previous[kViews], kViews);
}

TEST(AlignmentPriors, SmoothCorrectionsMakeTightStepsAndNoiseLooseOnes) {
  const AlignmentInput input = driveInput();
  PosePriors priors = drivePriors(input);
  PoseState state = zeroState(input);
  std::mt19937 random(1);
  std::normal_distribution<double> noise(0, 0.001);
  for (std::size_t v = 0; v < kViews; ++v) {
    const double drift = 0.001 * std::sin(0.05 * static_cast<double>(v));
    for (Eigen::Index i = 0; i < 6; ++i) state.views[v][i] = v % 2 == 0 ? drift : noise(random);
  }
  state.views[20].setConstant(0.01);  // one of the smooth ones jumps: it must not loosen the others
  learnSteps(input.views, state, priors);
  ASSERT_EQ(priors.step_sigmas.size(), 2U);
  for (Eigen::Index i = 0; i < 3; ++i) {
    EXPECT_LT(priors.step_sigmas[0][i], 2e-4);
    EXPECT_NEAR(priors.step_sigmas[1][i], 0.001 * std::sqrt(2.0), 0.6e-3);
  }
}

TEST(AlignmentPriors, ACameraWithFewStepsDoesNotLoosenTheOthers) {
  AlignmentInput input = driveInput();
  for (std::size_t v = 0; v < kViews; ++v) input.views[v].camera = v % 2 == 1 && v < 10 ? 1 : 0;
  PosePriors priors = drivePriors(input);
  const PoseState state = zeroState(input);
  learnSteps(input.views, state, priors);
  ASSERT_EQ(priors.step_sigmas.size(), 2U);
  EXPECT_LT(priors.step_sigmas[0].maxCoeff(), 1);
  EXPECT_EQ(priors.step_sigmas[1].minCoeff(), INFINITY);
  const PriorTerms terms(input.views, priors);
  PoseState moved = state;
  moved.views[3].setConstant(100);  // of camera 1: nothing but its own prior holds it
  EXPECT_NEAR(terms.cost(moved), 0.5 * terms.deviation(moved, 3).squaredNorm(), 1e-9 * terms.cost(moved));
}

TEST(AlignmentPriors, LeastStepIsThatOfAllViewsOfTheCamera) {
  AlignmentInput input = driveInput();
  std::vector<double> depths(input.views.size(), 10);
  depths[kViews - 1] = depths[kViews - 2] = 1000;  // the last view of each camera looks far
  PosePriors priors = makePriors(input, AlignmentParams{}, depths);
  learnSteps(input.views, zeroState(input), priors);
  ASSERT_EQ(priors.step_sigmas.size(), 2U);
  for (const Twist& sigma : priors.step_sigmas) EXPECT_LT(sigma[3], 0.1 * 0.05 * priors.view_sigmas[kViews - 1][3]);
}

TEST(AlignmentPriors, AStepIsMeasuredByThePriorOfItsOwnCamera) {
  const AlignmentInput input = driveInput();
  PosePriors priors = drivePriors(input);
  priors.camera_sigmas[0].setConstant(10);
  priors.camera_sigmas[1].setConstant(0.1);
  Eigen::VectorXd step = Eigen::VectorXd::Zero(static_cast<Eigen::Index>(6 * input.views.size()));
  step[6 * 3] = 0.5;  // a view of camera 1
  EXPECT_EQ(largestStep(step, input.views, priors), 5);
}

TEST(AlignmentPriors, FewViewsTeachNothing) {
  AlignmentInput input = driveInput();
  input.views.resize(10);
  PosePriors priors = drivePriors(input);
  learnSteps(input.views, zeroState(input), priors);
  EXPECT_TRUE(priors.step_sigmas.empty());
}

/// Oracle: numerical derivatives of cost().
TEST(AlignmentPriors, GradientAndHessianAreThoseOfTheCost) {
  AlignmentInput input = driveInput();
  input.views.resize(24);
  AlignmentParams params;
  params.align_time_offset = true;
  PosePriors priors = makePriors(input, params, std::vector<double>(input.views.size(), 10));
  PoseState state = zeroState(input);
  std::mt19937 random(2);
  std::normal_distribution<double> noise(0, 0.002);
  for (Twist& twist : state.views) twist = Twist::NullaryExpr([&] { return noise(random); });
  for (Twist& twist : state.cameras) twist = Twist::NullaryExpr([&] { return noise(random); });
  state.time_offsets = {0.01, -0.02};
  learnSteps(input.views, state, priors);
  ASSERT_FALSE(priors.step_sigmas.empty());

  const PriorTerms terms(input.views, priors);
  const auto linearize = [&](const PoseState& at, Eigen::VectorXd& gradient) {
    std::vector<Eigen::Triplet<double>> lower;
    gradient = Eigen::VectorXd::Zero(terms.size());
    terms.addTo(at, lower, gradient);
    Eigen::SparseMatrix<double> matrix(terms.size(), terms.size());
    matrix.setFromTriplets(lower.begin(), lower.end());
    return Eigen::MatrixXd(Eigen::MatrixXd(matrix).selfadjointView<Eigen::Lower>());
  };
  Eigen::VectorXd gradient;
  const Eigen::MatrixXd hessian = linearize(state, gradient);
  // The cost is quadratic, so central differences are exact but for rounding.
  for (const Eigen::Index i : {0, 3, 14, 35, 141, 144, 150, 151, 157}) {
    const double h = 1e-4;
    const auto moved = [&](double by) {
      PoseState at = state;
      if (i < 6 * 24) {
        at.views[static_cast<std::size_t>(i / 6)][i % 6] += by;
      } else if ((i - 144) % 7 < 6) {
        at.cameras[static_cast<std::size_t>((i - 144) / 7)][(i - 144) % 7] += by;
      } else {
        at.time_offsets[static_cast<std::size_t>((i - 144) / 7)] += by;
      }
      return at;
    };
    const double slope = (terms.cost(moved(h)) - terms.cost(moved(-h))) / (2 * h);
    EXPECT_NEAR(gradient[i], slope, 1e-5 * (1 + std::abs(slope))) << i;
    Eigen::VectorXd above, below;
    linearize(moved(h), above);
    linearize(moved(-h), below);
    EXPECT_LT(((above - below) / (2 * h) - hessian.col(i)).norm(), 1e-6 * hessian.col(i).norm()) << i;
  }
}

}  // namespace
}  // namespace cloud_colorizer::alignment
