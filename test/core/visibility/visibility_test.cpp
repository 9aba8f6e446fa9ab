// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause
/// Surfels, depth images and observations together, against exact ray casting.
#include <gtest/gtest.h>

#include "cloud_colorizer/visibility/observe.hpp"
#include "core/street_scene.hpp"

namespace cloud_colorizer {
namespace {

using test::Scan;
using test::Scene;

const Camera kCamera({1280, 800, 650, 650, 640, 400, DistortionModel::kPlumbBob, {-0.05, 0.01, 0.0003, -0.0002}});

struct Score {
  std::size_t visible = 0, lost = 0, hidden = 0, colored = 0;
  double lostShare() const { return static_cast<double>(lost) / std::max(1.0, static_cast<double>(visible)); }
  double coloredShare() const { return static_cast<double>(colored) / std::max(1.0, static_cast<double>(hidden)); }
};

/// Counts points that a view truly sees but that got no colour, and the reverse.
Score score(const Scene& scene, const Scan& scan, const std::vector<Eigen::Isometry3d>& poses,
            const DepthParams& params = {}) {
  const Surfels surfels = estimateSurfels(scan.points, {});
  const auto image = std::make_shared<cv::Mat>(800, 1280, CV_8UC1, cv::Scalar(100));
  const auto result = observe(scan.points, surfels, poses.size(),
                              [&](std::size_t k) {
                                DepthSplatter splatter(kCamera, poses[k].inverse().cast<float>(), params);
                                splatter.add(scan.points, surfels);
                                ObservedView view;
                                view.id = static_cast<std::uint32_t>(k);
                                view.camera = &kCamera;
                                view.map_from_camera = poses[k];
                                view.image = image;
                                view.depth = std::make_shared<DepthImage>(splatter.finish());
                                return view;
                              },
                              params, {});
  Score out;
  for (std::size_t i = 0; i < scan.truth.size(); ++i) {
    bool inside = false, visible = false;
    for (const auto& pose : poses) {
      const Eigen::Vector3f local = (pose.inverse() * scan.truth[i]).cast<float>();
      const auto pixel = kCamera.project(local);
      if (!pixel || local.norm() > params.reach()) continue;
      if (std::min({pixel->x(), pixel->y(), 1279 - pixel->x(), 799 - pixel->y()}) < 4) continue;  // image border
      inside = true;
      visible = visible || scene.sees(pose.translation(), scan.truth[i]);
    }
    if (!inside) continue;
    const bool colored = result.observations.offsets[i + 1] > result.observations.offsets[i];
    ++(visible ? out.visible : out.hidden);
    out.lost += visible && !colored;
    out.colored += !visible && colored;
  }
  return out;
}

/// Dense points of the face of a box that looks to -x, with noise along it.
void addFace(const test::Box& box, double width, double height, double noise, test::Thinner& thinner) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> side(-0.5, 0.5);
  std::normal_distribution<double> normal;
  for (int i = 0; i < static_cast<int>(width * height * 1200); ++i) {
    const Eigen::Vector3d truth(box.low.x(), width * side(random), height * side(random));
    thinner.add(truth + Eigen::Vector3d(noise * normal(random), 0, 0), truth);
  }
}

TEST(Visibility, DenseWallLosesUnderOnePercentFromNearAndFar) {
  for (const double distance : {5.0, 50.0}) {
    for (const double noise : {0.0, 0.02}) {
      const Scene scene{{{{distance, -60, -40}, {distance + 1, 60, 40}}}, {}};
      test::Thinner thinner(0.05);
      addFace(scene.boxes[0], 8, 5, noise, thinner);
      DepthParams params;
      params.max_view_distance = 60;
      const Score result = score(scene, thinner.finish(), {test::lookAlong({0, 0, 0}, 0)}, params);
      EXPECT_GT(result.visible, 10000U);
      EXPECT_LT(result.lostShare(), 0.01) << distance << " m, noise " << noise;
    }
  }
}

TEST(Visibility, WallHidesTheWallBehindIt) {
  const Scene scene{{{{6, -2, -2}, {6.2, 2, 2}}, {{9, -6, -4}, {9.2, 6, 4}}}, {}};
  test::Thinner thinner(0.05);
  addFace(scene.boxes[0], 4, 4, 0.02, thinner);
  addFace(scene.boxes[1], 12, 8, 0.02, thinner);
  const Score result = score(scene, thinner.finish(), {test::lookAlong({0, 0, 0}, 0)});
  EXPECT_GT(result.hidden, 5000U);
  EXPECT_LT(result.coloredShare(), 0.003);
  EXPECT_LT(result.lostShare(), 0.02);  // the wall behind is lost along the rim of the one in front
}

TEST(Visibility, StreetIsCoveredAndWhatIsHiddenStaysUncolored) {
  const Scene scene = test::makeStreet();
  std::vector<Eigen::Vector3d> places;
  std::vector<Eigen::Isometry3d> poses;
  for (int i = 0; i < 12; ++i) {
    places.emplace_back(1.5 * i, 0, 1.9);
    poses.push_back(test::lookAlong({1.5 * i + 0.5, 0.2, 1.65}, 35, 5));
    poses.push_back(test::lookAlong({1.5 * i + 0.5, -0.2, 1.65}, -35, 5));
  }
  test::Lidar lidar;
  lidar.columns = 900;
  DepthParams params;
  params.max_view_distance = 20;  // all that hides something nearer has been scanned
  const Score result = score(scene, test::sweep(scene, places, lidar, 0.05, 1), poses, params);
  RecordProperty("lost_per_mille", static_cast<int>(1000 * result.lostShare()));
  RecordProperty("colored_per_mille", static_cast<int>(1000 * result.coloredShare()));
  EXPECT_GT(result.visible, 100000U);
  EXPECT_GT(result.hidden, 5000U);
  EXPECT_LT(result.lostShare(), 0.03);
  EXPECT_LT(result.coloredShare(), 0.03);
}

}  // namespace
}  // namespace cloud_colorizer
