// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause
#include "cloud_colorizer/alignment/align.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <opencv2/imgproc.hpp>
#include <set>
#include <tuple>
#include <utility>

#include "alignment/aligner.hpp"
#include "alignment/gains.hpp"
#include "alignment/normal_equations.hpp"
#include "alignment/proof.hpp"
#include "cloud_colorizer/base/check.hpp"
#include "core/relief_scene.hpp"

namespace cloud_colorizer {
namespace {

using test::Relief;
using test::ReliefViews;

AlignmentParams looseParams() {
  AlignmentParams params;
  params.pose_rotation_prior = 0.5;  // deg: 1.3 px in these small images
  params.extrinsic_rotation_prior = 0.2;
  return params;
}

TEST(Alignment, KnownPoseErrorIsRecovered) {
  ReliefViews scene(8);
  scene.disturbPoses(0.4, 0.01, 1);
  scene.render(1);
  const double before = scene.meanError(scene.poses);
  const AlignmentResult result = align(scene.input(), looseParams(), {});
  EXPECT_GT(before, 1.0);
  EXPECT_LT(scene.meanError(result), 0.15);
  EXPECT_TRUE(result.poses_aligned);
  EXPECT_LT(result.residual_after, 0.6 * result.residual_before);
  EXPECT_NEAR(result.pixels, before, 0.5 * before);
}

TEST(Alignment, ExactDataAreUnharmed) {
  ReliefViews scene(8);
  scene.render(1);
  const AlignmentResult result = align(scene.input(), {}, {});
  EXPECT_LT(scene.meanError(result), 0.1);
  for (const ViewAlignment& view : result.views) {
    EXPECT_LT((view.exposure.gain - 1).abs().maxCoeff(), 0.01F);
    EXPECT_FALSE(view.refused);
    EXPECT_GT(view.weight, 0.7F);
  }
  EXPECT_TRUE(result.warnings.empty());
}

TEST(Alignment, WithoutProofTheInputStaysExactlyAsItIs) {
  ReliefViews scene(8);
  scene.render(1);
  const AlignmentResult exact = align(scene.input(), {}, {});
  EXPECT_EQ(exact.pixels, 0);
  EXPECT_FALSE(exact.corrections_kept);
  EXPECT_EQ(exact.residual_before, exact.residual_after);
  for (std::size_t v = 0; v < scene.poses.size(); ++v) {
    EXPECT_EQ(exact.views[v].map_from_camera.matrix(), scene.true_poses[v].matrix());
    EXPECT_TRUE((exact.views[v].exposure.gain == 1).all());
  }
  scene.disturbPoses(0.4, 0.01, 1);
  const AlignmentResult disturbed = align(scene.input(), looseParams(), {});
  EXPECT_TRUE(disturbed.corrections_kept);
  EXPECT_GT(disturbed.residual_before - disturbed.residual_after, 10 * disturbed.residual_error);
}

TEST(Alignment, MeanBrightnessStays) {
  ReliefViews scene(6);
  scene.gains = {0.7, 1.3, 0.8, 1.2, 0.9, 1.3};
  scene.render(1);
  const AlignmentResult result = align(scene.input(), {}, {});
  double before = 0, after = 0;
  for (std::size_t v = 0; v < scene.gains.size(); ++v) {
    before += scene.gains[v] / 6;
    after += scene.gains[v] * static_cast<double>(result.views[v].exposure.gain.mean()) / 6;
  }
  EXPECT_NEAR(after / before, 1, 0.01);
}

TEST(Alignment, GainsAreRecoveredWhilePosesAreOff) {
  ReliefViews scene(8);
  scene.disturbPoses(0.4, 0.01, 2);
  scene.gains = {0.8, 1.1, 1.0, 0.9, 1.2, 1.05, 0.95, 1.0};
  scene.render(2);
  AlignmentParams params = looseParams();
  const AlignmentResult both = align(scene.input(), params, {});
  params.align_poses = AlignPoses::kNone;
  const AlignmentResult gains_only = align(scene.input(), params, {});
  for (std::size_t v = 0; v < scene.gains.size(); ++v) {
    const double ratio = scene.gains[v] / scene.gains[0];
    const auto relative = [&](const AlignmentResult& result) {
      return static_cast<double>(result.views[0].exposure.gain[1] / result.views[v].exposure.gain[1]);
    };
    EXPECT_NEAR(relative(both) / ratio, 1, 0.01) << "view " << v;
    EXPECT_NEAR(relative(gains_only) / ratio, 1, 0.03) << "view " << v;
  }
  EXPECT_FALSE(gains_only.poses_aligned);
  EXPECT_EQ(gains_only.views[3].map_from_camera.matrix(), scene.poses[3].matrix());
}

TEST(Alignment, TexturelessViewsStayPut) {
  ReliefViews scene(6);
  scene.relief.contrast = 0;
  scene.disturbPoses(0.2, 0.005, 3);
  scene.render(0);
  const AlignmentResult result = align(scene.input(), looseParams(), {});
  EXPECT_LT(result.pixels, 0.02);
}

TEST(Alignment, SharedErrorOfACameraBecomesItsCorrection) {
  ReliefViews scene(8);
  const Eigen::Isometry3d error(Eigen::AngleAxisd(0.006, Eigen::Vector3d(0.6, 0.8, 0)));
  for (std::size_t v = 0; v < scene.poses.size(); ++v) scene.poses[v] = scene.true_poses[v] * error;
  scene.render(1);
  AlignmentParams params = looseParams();
  params.align_poses = AlignPoses::kCameras;
  const AlignmentResult result = align(scene.input(), params, {});
  EXPECT_LT(scene.meanError(result), 0.3 * scene.meanError(scene.poses));
  const Eigen::AngleAxisd found(result.cameras[0].corrected_from_camera.linear());
  EXPECT_NEAR(found.angle(), 0.006, 0.002);
  // Every view moved by the camera's correction and by nothing else.
  for (std::size_t v = 0; v < scene.poses.size(); ++v) {
    const Eigen::Isometry3d expected = scene.poses[v] * result.cameras[0].corrected_from_camera.inverse();
    EXPECT_TRUE(result.views[v].map_from_camera.isApprox(expected, 1e-5));
  }
}

TEST(Alignment, CalibrationIsBlamedOnlyWhereItExplainsAllViews) {
  ReliefViews scene(8);
  const Eigen::Isometry3d error(Eigen::AngleAxisd(0.012, Eigen::Vector3d(0.6, 0.8, 0)));
  for (std::size_t v = 0; v < scene.poses.size(); ++v) scene.poses[v] = scene.true_poses[v] * error;
  scene.render(1);
  const AlignmentResult of_camera = align(scene.input(), looseParams(), {});
  ASSERT_EQ(of_camera.warnings.size(), 1U);
  EXPECT_NE(of_camera.warnings[0].find("calibration looks wrong"), std::string::npos) << of_camera.warnings[0];
  scene.poses = scene.true_poses;
  scene.disturbPoses(0.8, 0.02, 1);
  const AlignmentResult of_views = align(scene.input(), looseParams(), {});
  EXPECT_LT(scene.meanError(of_views), 0.3 * scene.meanError(scene.poses));
  ASSERT_EQ(of_views.warnings.size(), 1U);
  EXPECT_NE(of_views.warnings[0].find("the poses or the map differ"), std::string::npos) << of_views.warnings[0];
}

// A drive over the relief: the images were taken `late` seconds after their stamps say.
ReliefViews driveOver(double late) {
  ReliefViews scene(12);
  const auto poseAt = [](double t) {
    return Relief::poseAbove(-1 + 1.1 * t + 0.25 * std::sin(3 * t), 0.3 * std::sin(2 * t), 0.1 * std::sin(4 * t), 0);
  };
  for (std::size_t v = 0; v < scene.poses.size(); ++v) {
    const double t = 0.15 * static_cast<double>(v);
    scene.stamps.push_back(t);
    scene.poses[v] = poseAt(t);
    scene.true_poses[v] = poseAt(t + late);
  }
  scene.render(2);
  return scene;
}

Eigen::VectorXf intensityOf(const ReliefViews& scene, const Points& points) {
  Eigen::VectorXf intensity(points.cols());
  for (Eigen::Index i = 0; i < points.cols(); ++i) {
    const Eigen::Vector3d color = scene.relief.colorAt(points(0, i), points(1, i));
    intensity[i] = static_cast<float>(std::pow(color[1] / 255, 2) * 80);  // another quantity, of the same surface
  }
  return intensity;
}

TEST(Alignment, TimeOffsetIsFoundAndReported) {
  const ReliefViews scene = driveOver(0.05);
  AlignmentInput input = scene.input();
  input.intensity = intensityOf(scene, input.points);
  const AlignmentResult reported = align(input, looseParams(), {});
  ASSERT_EQ(reported.warnings.size(), 1U);
  EXPECT_NE(reported.warnings[0].find("agree best at +0.0"), std::string::npos) << reported.warnings[0];
  AlignmentParams params = looseParams();
  params.align_time_offset = true;
  const AlignmentResult applied = align(input, params, {});
  EXPECT_NEAR(applied.cameras[0].time_offset, 0.05, 0.005);
  EXPECT_LT(scene.meanError(applied), 0.3);
}

TEST(Alignment, RightClockIsNotSuspected) {
  const ReliefViews scene = driveOver(0);
  const AlignmentResult result = align(scene.input(), looseParams(), {});
  EXPECT_TRUE(result.warnings.empty()) << result.warnings[0];
  EXPECT_NEAR(result.cameras[0].time_offset, 0, 0.01);
  EXPECT_FALSE(result.cameras[0].time_offset_suspect);
}

TEST(Alignment, IntensityHoldsTheCommonShift) {
  ReliefViews scene(8);
  // All views moved over the relief together: they still agree with each other nearly.
  for (Eigen::Isometry3d& pose : scene.poses) pose.translation() += Eigen::Vector3d(0.024, -0.016, 0);
  scene.render(2);
  AlignmentInput input = scene.input();
  input.intensity = intensityOf(scene, input.points);
  const AlignmentResult tied = align(input, looseParams(), {});
  EXPECT_LT(scene.meanError(tied), 0.15);
  AlignmentParams params = looseParams();
  params.align_to_intensity = false;
  EXPECT_LT(scene.meanError(tied), scene.meanError(align(input, params, {})));
}

TEST(Alignment, SameForAnyNumberOfThreads) {
  ReliefViews scene(5);
  scene.disturbPoses(0.3, 0.01, 4);
  scene.render(2);
  AlignmentInput input = scene.input();
  input.num_threads = 1;
  const AlignmentResult one = align(input, looseParams(), {});
  input.num_threads = 3;
  const AlignmentResult three = align(input, looseParams(), {});
  for (std::size_t v = 0; v < one.views.size(); ++v) {
    EXPECT_EQ(one.views[v].map_from_camera.matrix(), three.views[v].map_from_camera.matrix());
    EXPECT_TRUE((one.views[v].exposure.gain == three.views[v].exposure.gain).all());
    EXPECT_EQ(one.views[v].weight, three.views[v].weight);
  }
}

TEST(Alignment, SameForAnyMemory) {
  ReliefViews scene(5);
  scene.disturbPoses(0.3, 0.01, 4);
  scene.render(2);
  AlignmentInput input = scene.input();
  input.memory_limit = 1000;
  const AlignmentResult much = align(input, looseParams(), {});
  input.memory_limit = 0.1;  // MB: room for 100 points of each view, and for one blurred image
  const AlignmentResult little = align(input, looseParams(), {});
  for (std::size_t v = 0; v < much.views.size(); ++v) {
    EXPECT_EQ(much.views[v].map_from_camera.matrix(), little.views[v].map_from_camera.matrix());
    EXPECT_TRUE((much.views[v].exposure.gain == little.views[v].exposure.gain).all());
  }
}

TEST(Alignment, BlurredViewWeighsLess) {
  ReliefViews scene(6);
  scene.render(1);
  cv::Mat blurred;
  cv::blur(scene.images[2], blurred, cv::Size(13, 13));
  scene.images[2] = blurred;
  const AlignmentResult result = align(scene.input(), looseParams(), {});
  EXPECT_LT(result.views[2].weight, 0.6F);
  EXPECT_GT(result.views[0].weight, 0.8F);
}

TEST(Alignment, OneViewOrNoOverlapDoesNothingAndSaysSo) {
  ReliefViews scene(1);
  scene.render(0);
  const AlignmentResult result = align(scene.input(), {}, {});
  EXPECT_EQ(result.views[0].map_from_camera.matrix(), scene.poses[0].matrix());
  EXPECT_TRUE((result.views[0].exposure.gain == 1).all());
  ASSERT_EQ(result.warnings.size(), 1U);
  EXPECT_NE(describe(result).find("nothing was changed"), std::string::npos);
}

TEST(Alignment, VignettingIsRecoveredAndOthersAreLeftAlone) {
  ReliefViews scene(8);
  scene.gains = {0.9, 1.1, 1.0, 0.95, 1.05, 1.0, 0.9, 1.1};
  scene.render(1);
  AlignmentParams params = looseParams();
  params.align_vignetting = true;
  const AlignmentResult without = align(scene.input(), params, {});
  EXPECT_TRUE((without.views[0].exposure.vignetting == 0).all());
  EXPECT_EQ(describe(without).find("darken"), std::string::npos);
  scene.relief.darkening = 0.25;
  scene.render(1);
  const AlignmentResult unwanted = align(scene.input(), looseParams(), {});
  EXPECT_TRUE((unwanted.views[0].exposure.vignetting == 0).all());
  const AlignmentResult result = align(scene.input(), params, {});
  const Exposure& exposure = result.views[3].exposure;
  const auto width = static_cast<float>(scene.relief.width), height = static_cast<float>(scene.relief.height);
  const auto undone = [&](float u) {
    const float x = 2 * u / width - (width - 1) / width;
    return exposure.brightening(u, (height - 1) / 2, width, height) * (1 - 0.25F * x * x);
  };
  for (const float u : {10.0F, 40.0F, 79.5F, 120.0F, 150.0F}) EXPECT_NEAR(undone(u) / undone(79.5F), 1, 0.02) << u;
  for (std::size_t v = 0; v < scene.gains.size(); ++v) {
    const float product = result.views[v].exposure.gain[1] * static_cast<float>(scene.gains[v]);
    EXPECT_NEAR(product / (result.views[0].exposure.gain[1] * 0.9F), 1, 0.01) << v;
  }
  EXPECT_NE(describe(result).find("darken"), std::string::npos);
}

TEST(Alignment, GreyImagesHaveOneGain) {
  ReliefViews scene(4);
  scene.gains = {0.8, 1.2, 0.9, 1.1};
  scene.render(1);
  AlignmentInput input = scene.input();
  input.images = [&](std::size_t v) {
    auto image = std::make_shared<cv::Mat>();
    cv::cvtColor(scene.images[v], *image, cv::COLOR_RGB2GRAY);
    return image;
  };
  const AlignmentResult result = align(input, {}, {});
  ASSERT_EQ(result.views[0].exposure.gain.size(), 1);
  EXPECT_NEAR(result.views[0].exposure.gain[0] / result.views[1].exposure.gain[0], 1.5, 0.02);
}

TEST(Alignment, ImagesBeyond8BitAreLeftAloneWithAWarning) {
  ReliefViews scene(4);
  scene.disturbPoses(0.4, 0.01, 1);
  scene.render(1);
  for (const int depth : {CV_16U, CV_32F}) {
    AlignmentInput input = scene.input();
    input.images = [&](std::size_t v) {
      auto image = std::make_shared<cv::Mat>();
      scene.images[v].convertTo(*image, depth, 200);
      return image;
    };
    const AlignmentResult result = align(input, {}, {});
    ASSERT_EQ(result.warnings.size(), 1U);
    EXPECT_NE(result.warnings[0].find("8 bits"), std::string::npos);
    EXPECT_FALSE(result.poses_aligned || result.exposure_aligned);
    EXPECT_EQ(result.views[2].map_from_camera.matrix(), scene.poses[2].matrix());
  }
}

TEST(Alignment, EmptyInputGivesEmptyResult) {
  const AlignmentResult result = align({}, {}, {});
  EXPECT_TRUE(result.views.empty());
  EXPECT_FALSE(result.poses_aligned);
  EXPECT_FALSE(describe(result).empty());
  EXPECT_FALSE(alignmentPicture(result).empty());
}

TEST(Alignment, BadInputIsRefused) {
  ReliefViews scene(2);
  scene.render(0);
  AlignmentInput input = scene.input();
  input.views[1].camera = 3;
  EXPECT_THROW(align(input, {}, {}), std::invalid_argument);
  input = scene.input();
  input.surfels.radii.conservativeResize(3);
  EXPECT_THROW(align(input, {}, {}), std::invalid_argument);
  input = scene.input();
  input.intensity.setOnes(4);
  EXPECT_THROW(align(input, {}, {}), std::invalid_argument);
  input = scene.input();
  input.depth = nullptr;
  EXPECT_THROW(align(input, {}, {}), std::invalid_argument);
  input = scene.input();
  input.images = [](std::size_t) { return std::make_shared<const cv::Mat>(cv::Mat::zeros(5, 5, CV_8UC3)); };
  EXPECT_THROW(align(input, {}, {}), std::invalid_argument);
  AlignmentParams params;
  params.pose_rotation_prior = 0;
  EXPECT_THROW(align(scene.input(), params, {}), std::invalid_argument);
}

TEST(Alignment, CancelledStops) {
  ReliefViews scene(4);
  scene.render(0);
  Callbacks callbacks;
  callbacks.cancelled = [] { return true; };
  EXPECT_ANY_THROW(align(scene.input(), {}, callbacks));
}

TEST(Alignment, AsksBeforeEachImageAndEachSamplingOfAViewWhetherToGoOn) {
  ReliefViews scene(4);
  scene.disturbPoses(0.3, 0.01, 4);
  scene.render(1);
  AlignmentInput input = scene.input();
  input.num_threads = 1;
  int asked = 0, loaded = 0, most_loaded = 0, stop_at = 0;
  input.images = [&, images = input.images](std::size_t v) { return ++loaded, images(v); };
  input.depth = [&, depth = input.depth](std::size_t v, const auto& pose) { return ++loaded, depth(v, pose); };
  Callbacks callbacks;
  callbacks.cancelled = [&] {
    most_loaded = std::max(most_loaded, std::exchange(loaded, 0));
    return ++asked == stop_at;
  };
  align(input, looseParams(), callbacks);
  EXPECT_LE(most_loaded, 2);
  EXPECT_GT(asked, 200);
  for (const int stop : {1, 2, asked / 3, asked / 2, asked - 1}) {
    asked = loaded = 0;
    stop_at = stop;
    EXPECT_THROW(align(input, looseParams(), callbacks), Cancelled);
    EXPECT_EQ(asked, stop);
    EXPECT_EQ(loaded, 0);
  }
}

TEST(Alignment, ReasonsOfARefusalAreSeparated) {
  using alignment::refusal;
  alignment::Evidence proven;
  proven.agreement.all = {9, 5, 1, 20};
  EXPECT_EQ(refusal(1, proven), "");
  EXPECT_EQ(refusal(1, {}), "held-back points do not agree better with its correction");
  EXPECT_EQ(refusal(7.25, {}),
            "its correction would be 7.2 times what the priors expect; held-back points do not agree better with its "
            "correction");
}

TEST(AlignmentEquations, WhatCannotBeSolvedHasNoSolution) {
  Eigen::SparseMatrix<double> lower(2, 2);
  lower.insert(0, 0) = lower.insert(1, 0) = lower.insert(1, 1) = 2;
  EXPECT_FALSE(alignment::solveLower(lower, Eigen::Vector2d(1, 2)));
  lower.coeffRef(1, 1) = 4;
  EXPECT_TRUE(alignment::solveLower(lower, Eigen::Vector2d(2, 2))->isApprox(Eigen::Vector2d(1, 0)));
  lower.coeffRef(1, 1) = NAN;
  EXPECT_FALSE(alignment::solveLower(lower, Eigen::Vector2d(1, 2)));
}

TEST(AlignmentEquations, GainsStayFiniteWhereTheirEquationsCannotBeSolved) {
  const std::vector<alignment::Sight> all = {{0, 1, 9}, {1, 1, 9}};
  const alignment::Tracks tracks = alignment::makeTracks({all, all}, 2, 10);
  const Eigen::VectorXd gains =
      alignment::estimateLogGains(tracks, {90, 110, 100, 100}, {1, INFINITY, 1, 1}, 5, Workers(1, {}));
  EXPECT_TRUE(gains.allFinite());
}

TEST(AlignmentReport, HasALineAViewAndAPicture) {
  ReliefViews scene(3);
  scene.render(0);
  const AlignmentInput input = scene.input();
  const AlignmentResult result = align(input, {}, {});
  const std::string csv = alignmentCsv(result, input.views);
  EXPECT_EQ(std::count(csv.begin(), csv.end(), '\n'), 4);
  EXPECT_NE(describe(result).find("3 views"), std::string::npos);
  EXPECT_EQ(alignmentPicture(result).rows, 600);
}

}  // namespace
}  // namespace cloud_colorizer
