// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause
#include "alignment/proof.hpp"

#include <gtest/gtest.h>

#include <map>
#include <random>
#include <tuple>

#include "core/relief_scene.hpp"

namespace cloud_colorizer::alignment {
namespace {

/// Views that all see points 0 ... n - 1, in blocks of one point each.
struct SharedPoints {
  Tracks tracks;
  Blocks blocks;

  SharedPoints(std::size_t num_views, std::uint32_t num_points) {
    std::vector<Sight> sights;
    for (std::uint32_t p = 0; p < num_points; ++p) {
      sights.push_back({p, 1, 9});
      blocks.of_point.push_back(static_cast<std::uint16_t>(3 * (p % 500)));  // all of them are held back
    }
    tracks = makeTracks(std::vector<std::vector<Sight>>(num_views, sights), num_points, num_points);
  }

  Showing showing(double offset_of_last, double noise, unsigned seed) const {
    std::mt19937 random(seed);
    std::normal_distribution<double> normal(0, noise);
    Showing result;
    for (std::size_t k = 0; k < tracks.numObservations(); ++k) {
      const double offset = tracks.views[k] + 1 == tracks.numViews() ? offset_of_last : 0;
      result.values.push_back(static_cast<float>(100 + offset + normal(random)));
      result.weights.push_back(1);
    }
    return result;
  }
};

TEST(AlignmentProof, PointsOfABlockShareANumberAndAThirdIsHeldBack) {
  const Points points = Points::Random(3, 30000);
  const Blocks blocks = makeBlocks(points, 0.1);
  std::map<std::tuple<double, double, double>, int> of_block;
  double held_back = 0;
  for (Eigen::Index p = 0; p < points.cols(); ++p) {
    const Eigen::Vector3d cell = (points.col(p).cast<double>() / 0.1).array().floor();
    const int block = blocks.of_point[static_cast<std::size_t>(p)];
    EXPECT_EQ(of_block.emplace(std::tuple(cell[0], cell[1], cell[2]), block).first->second, block);
    held_back += blocks.isHeldBack(static_cast<std::uint32_t>(p));
  }
  EXPECT_NEAR(held_back / static_cast<double>(points.cols()), 1 / 3.0, 0.03);
  EXPECT_FALSE(Blocks{}.isHeldBack(7));
}

TEST(AlignmentProof, AGainThatEveryBlockSeesIsProvenAndItsReverseIsDisproven) {
  const SharedPoints shared(4, 60);
  const Showing off = shared.showing(10, 1, 1), right = shared.showing(0, 1, 1);
  const Choice last = Choice::ofView(3, 4);
  EXPECT_TRUE(evidence(shared.tracks, shared.blocks, off, right, last).isProven());
  EXPECT_TRUE(evidence(shared.tracks, shared.blocks, right, off, last).agreement.all.isDisproven());
  EXPECT_NEAR(evidence(shared.tracks, shared.blocks, off, right, last).agreement.all.mean(), 9, 1);
}

TEST(AlignmentProof, NoiseProvesNothing) {
  const SharedPoints shared(4, 60);
  int proven = 0;
  for (unsigned seed = 0; seed < 100; ++seed) {
    const Showing a = shared.showing(0, 1, 2 * seed), b = shared.showing(0, 1, 2 * seed + 1);
    proven += evidence(shared.tracks, shared.blocks, a, b, Choice::ofView(3, 4)).isProven();
  }
  EXPECT_LE(proven, 3);
}

TEST(AlignmentProof, FewBlocksProveNothing) {
  const SharedPoints shared(4, 15);
  const Showing off = shared.showing(10, 1, 1), right = shared.showing(0, 1, 1);
  EXPECT_FALSE(evidence(shared.tracks, shared.blocks, off, right, Choice::ofView(3, 4)).isProven());
}

TEST(AlignmentProof, AStripAtOneEndOfTheImageProvesNothing) {
  const SharedPoints shared(4, 60);
  Showing off = shared.showing(10, 1, 1), right = shared.showing(0, 1, 1);
  right.right.assign(shared.tracks.numObservations(), 1);
  off.right = right.right;
  EXPECT_FALSE(evidence(shared.tracks, shared.blocks, off, right, Choice::ofView(3, 4)).isProven());
  for (std::size_t k = 0; k < right.right.size(); k += 2) off.right[k] = right.right[k] = 0;
  EXPECT_TRUE(evidence(shared.tracks, shared.blocks, off, right, Choice::ofView(3, 4)).isProven());
}

TEST(AlignmentProof, IntensityAloneMustHelpInBothHalves) {
  const SharedPoints alone(1, 80);
  Showing before = alone.showing(0, 1, 1), after = before;
  std::mt19937 random(3);
  std::normal_distribution<double> normal(0, 0.1);
  const auto evidenceWith = [&](double left, double right) {
    before.unexplained.clear(), after.unexplained.clear(), after.right.clear();
    for (int k = 0; k < 80; ++k) {
      before.unexplained.push_back(static_cast<float>(-0.2 + normal(random)));
      after.unexplained.push_back(static_cast<float>(-0.2 - (k % 2 == 0 ? left : right) + normal(random)));
      after.right.push_back(k % 2 != 0);
    }
    return evidence(alone.tracks, alone.blocks, before, after, Choice::ofAll(1));
  };
  EXPECT_TRUE(evidenceWith(0.2, 0.2).isProven());
  EXPECT_FALSE(evidenceWith(0.4, 0).isProven());
  EXPECT_FALSE(evidenceWith(0, 0.4).isProven());
  EXPECT_FALSE(evidenceWith(0, 0).isProven());
}

TEST(AlignmentProof, WhatIsHeldBackHasNoWeightInAnEstimate) {
  SharedPoints shared(2, 4);
  shared.blocks.of_point = {0, 1, 2, 3};
  const std::vector<float> weights = estimateWeights(shared.tracks, shared.blocks, std::vector<float>(8, 1));
  EXPECT_EQ(weights, (std::vector<float>{0, 1, 1, 0, 0, 1, 1, 0}));
}

// One view of each camera and hardly an overlap: the intensity may fit anywhere, and nothing may move.
TEST(AlignmentProof, CamerasWithoutOverlapStayWhereTheyAre) {
  test::ReliefViews scene(4);
  for (std::size_t v = 0; v < 4; ++v)
    scene.true_poses[v] = scene.poses[v] = test::Relief::poseAbove(-3.0 + 2.0 * double(v), 0, 0, 0);
  scene.render(3);
  AlignmentInput input = scene.input();
  for (std::uint32_t v = 0; v < 4; ++v) {
    input.views[v].camera = v;
    if (v > 0) input.cameras.push_back(input.cameras[0]);
  }
  std::mt19937 random(5);
  std::uniform_real_distribution<float> uniform;
  input.intensity = Eigen::VectorXf::NullaryExpr(input.points.cols(), [&] { return uniform(random); });
  const AlignmentResult result = align(input, {}, {});
  for (std::size_t v = 0; v < 4; ++v) {
    EXPECT_EQ(result.views[v].map_from_camera.matrix(), scene.poses[v].matrix()) << v;
  }
}

// Exact poses, but a sparse and rough map: every point lies off the surface by a twentieth of a metre.
TEST(AlignmentProof, ExactPosesOfASparseMapStay) {
  for (const int num_points : {700, 3000}) {
    test::ReliefViews scene(12);
    scene.num_points = num_points;
    scene.render(3);
    AlignmentInput input = scene.input();
    std::mt19937 random(7);
    std::normal_distribution<float> normal(0, 0.05F);
    for (Eigen::Index p = 0; p < input.points.cols(); ++p) input.points(2, p) += normal(random);
    const AlignmentResult result = align(input, {}, {});
    EXPECT_LT(scene.meanError(result), 0.1) << num_points;
  }
}

}  // namespace
}  // namespace cloud_colorizer::alignment
