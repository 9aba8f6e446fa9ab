// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause
#include "cloud_colorizer/visibility/observe.hpp"

#include <gtest/gtest.h>

#include <limits>

namespace cloud_colorizer {
namespace {

const Camera kCamera({100, 80, 100, 100, 49.5, 39.5, DistortionModel::kPlumbBob, {}});
DepthParams reaching40Meters() {
  DepthParams params;
  params.max_view_distance = 40;
  return params;
}
const DepthParams kDepth = reaching40Meters();
const ObserveParams kParams;

std::shared_ptr<DepthImage> openDepth() {
  auto depth = std::make_shared<DepthImage>();
  depth->depth = cv::Mat1f(40, 50, std::numeric_limits<float>::infinity());
  depth->edge = cv::Mat1b(40, 50, static_cast<unsigned char>(0));
  depth->cell_size = 2;
  depth->pixel_angle = 0.01F;
  return depth;
}

/// Channel c at (u, v) is c + 2 u + v: bilinear sampling is exact on it.
template <class T>
cv::Mat ramp(int type, int channels) {
  cv::Mat image(80, 100, CV_MAKETYPE(type, channels));
  for (int v = 0; v < 80; ++v) {
    for (int u = 0; u < 100; ++u) {
      for (int c = 0; c < channels; ++c) image.ptr<T>(v)[u * channels + c] = static_cast<T>(c + 2 * u + v);
    }
  }
  return image;
}

Eigen::ArrayXf arrayOf(const std::vector<float>& numbers) {
  return Eigen::Map<const Eigen::ArrayXf>(numbers.data(), static_cast<Eigen::Index>(numbers.size()));
}

ObservedView makeView(std::uint32_t id = 0, double back = 0) {
  ObservedView view;
  view.id = id;
  view.camera = &kCamera;
  view.map_from_camera.translation().z() = -back;
  view.image = std::make_shared<cv::Mat>(ramp<std::uint8_t>(CV_8U, 3) / 2);
  view.depth = openDepth();
  return view;
}

struct Scene {
  Points points;
  Surfels surfels;
};

Scene makeScene(const std::vector<Eigen::Vector3f>& points) {
  const auto n = static_cast<Eigen::Index>(points.size());
  Scene scene{Points(3, n), {Eigen::Matrix3Xf::Zero(3, n), Eigen::VectorXf::Constant(n, 0.05F), {}}};
  for (Eigen::Index i = 0; i < n; ++i) scene.points.col(i) = points[static_cast<std::size_t>(i)];
  scene.surfels.normals.row(2).setOnes();
  return scene;
}

ObserveResult look(const Scene& scene, const std::vector<ObservedView>& views, const ObserveParams& params = kParams) {
  return observe(
      scene.points, scene.surfels, views.size(), [&](std::size_t k) { return views[k]; }, kDepth, params);
}

TEST(Observe, NoPointsOrNoViewsGiveNoObservations) {
  const auto no_points = look(makeScene({}), {makeView()});
  EXPECT_EQ(no_points.observations.offsets, std::vector<std::uint32_t>{0});
  const auto no_views = look(makeScene({{0, 0, 1}}), {});
  EXPECT_EQ(no_views.observations.offsets, (std::vector<std::uint32_t>{0, 0}));
  EXPECT_EQ(no_views.observations.values.cols(), 0);
}

TEST(Observe, SamplesEveryTypeBilinearly) {
  const Scene scene = makeScene({{0.0125F, -0.0325F, 1}});  // pixel 50.75, 36.25
  const std::vector<cv::Mat> images{ramp<std::uint8_t>(CV_8U, 1), ramp<std::uint8_t>(CV_8U, 3),
                                    ramp<std::uint16_t>(CV_16U, 4), ramp<float>(CV_32F, 5)};
  for (const cv::Mat& image : images) {
    ObservedView view = makeView();
    view.image = std::make_shared<cv::Mat>(image);
    const auto result = look(scene, {view});
    ASSERT_EQ(result.observations.values.rows(), image.channels());
    ASSERT_EQ(result.observations.values.cols(), 1);
    for (int c = 0; c < image.channels(); ++c) {
      EXPECT_NEAR(result.observations.values(c, 0), static_cast<float>(c) + 2 * 50.75F + 36.25F, 1e-3);
    }
  }
}

TEST(Observe, SaturatedValuesWeighLittle) {
  const Scene scene = makeScene({{0, 0, 1}});
  const auto weightAt = [&](const cv::Mat& image) {
    ObservedView view = makeView();
    view.image = std::make_shared<cv::Mat>(image);
    return look(scene, {view}).observations.weights.at(0);
  };
  const float full = weightAt(cv::Mat(80, 100, CV_8UC3, cv::Scalar(245, 245, 245)));
  EXPECT_NEAR(weightAt(cv::Mat(80, 100, CV_8UC3, cv::Scalar(200, 200, 254))), 0.05F * full, 1e-6);
  EXPECT_NEAR(weightAt(cv::Mat(80, 100, CV_16UC1, cv::Scalar(65535))), 0.05F * full, 1e-6);
  EXPECT_EQ(weightAt(cv::Mat(80, 100, CV_16UC1, cv::Scalar(255))), full);
  EXPECT_EQ(weightAt(cv::Mat(80, 100, CV_32FC1, cv::Scalar(1e9))), full);
}

TEST(Observe, AppliesTheExposure) {
  const Scene scene = makeScene({{0, 0, 1}});
  ObservedView view = makeView();
  const Eigen::VectorXf plain = look(scene, {view}).observations.values.col(0);
  view.exposure.gain = arrayOf({1, 2, 0.5F});
  view.exposure.offset = arrayOf({10, 0, -5});
  const Eigen::VectorXf corrected = look(scene, {view}).observations.values.col(0);
  EXPECT_TRUE(corrected.isApprox(Eigen::Vector3f(plain[0] + 10, plain[1] * 2, plain[2] * 0.5F - 5)));
}

TEST(Observe, CountsWhyPointsAreNotSeen) {
  ObservedView view = makeView();
  auto depth = openDepth();
  depth->depth.colRange(0, 25) = 0.5F;
  depth->edge.rowRange(30, 40) = 255;
  view.depth = depth;
  cv::Mat1b mask(80, 100, static_cast<unsigned char>(255));
  mask.rowRange(0, 20) = 0;
  view.mask = std::make_shared<cv::Mat>(mask);
  const auto result = look(makeScene({{0, 0, -1},        // behind
                                      {0.49F, 0, 1},     // in the border of the image
                                      {0, 0, 100},       // too far
                                      {-0.2F, 0, 1},     // behind the surface at 0.5 m
                                      {0.1F, -0.3F, 1},  // masked
                                      {0.1F, 0.3F, 1},   // at an edge
                                      {0.1F, 0, 1}}),    // seen
                           {view});
  EXPECT_EQ(result.stats.outside, 2U);
  EXPECT_EQ(result.stats.too_far, 1U);
  EXPECT_EQ(result.stats.hidden, 1U);
  EXPECT_EQ(result.stats.masked, 1U);
  EXPECT_EQ(result.stats.edge, 1U);
  EXPECT_EQ(result.stats.seen, 1U);
  EXPECT_EQ(result.observations.offsets, (std::vector<std::uint32_t>{0, 0, 0, 0, 0, 0, 1, 2}));
  EXPECT_EQ(result.unseen, (std::vector<Unseen>{Unseen::kOutside, Unseen::kOutside, Unseen::kTooFar, Unseen::kHidden,
                                                Unseen::kMasked, Unseen::kSeen, Unseen::kSeen}));
}

TEST(Observe, NanPixelIsSkippedAsMasked) {
  ObservedView view = makeView();
  cv::Mat image = ramp<float>(CV_32F, 1);
  image.at<float>(40, 50) = std::numeric_limits<float>::quiet_NaN();
  view.image = std::make_shared<cv::Mat>(image);
  const auto result = look(makeScene({{0, 0, 1}, {0.1F, 0, 1}}), {view});
  EXPECT_EQ(result.stats.masked, 1U);
  EXPECT_EQ(result.observations.offsets, (std::vector<std::uint32_t>{0, 0, 1}));
}

TEST(Observe, KeepsTheBestViewsByAscendingId) {
  ObserveParams params;
  params.max_views = 3;
  std::vector<ObservedView> views;
  for (const std::uint32_t id : {9U, 2U, 5U, 7U, 1U, 3U}) views.push_back(makeView(id, id));  // farther by id
  const auto result = look(makeScene({{0, 0, 1}}), views, params);
  EXPECT_EQ(result.observations.views, (std::vector<std::uint32_t>{1, 2, 3}));
  EXPECT_FLOAT_EQ(result.observations.distances[0], 2);
  EXPECT_FLOAT_EQ(result.observations.distances[2], 4);
  EXPECT_GT(result.observations.weights[0], result.observations.weights[2]);
}

TEST(Observe, EqualViewsAreKeptByLowerId) {
  ObserveParams params;
  params.max_views = 2;
  std::vector<ObservedView> views;
  for (const std::uint32_t id : {4U, 8U, 1U, 6U, 2U}) views.push_back(makeView(id));
  EXPECT_EQ(look(makeScene({{0, 0, 1}}), views, params).observations.views, (std::vector<std::uint32_t>{1, 2}));
}

TEST(Observe, ManyViewsOfManyPointsAgreeWithBruteForce) {
  std::vector<Eigen::Vector3f> places;
  for (int i = 0; i < 50; ++i) places.emplace_back(0.01F * static_cast<float>(i - 25), 0, 1);
  std::vector<ObservedView> views;
  for (std::uint32_t id = 0; id < 13; ++id) views.push_back(makeView(id, id));
  const Scene scene = makeScene(places);
  const auto result = look(scene, views);
  ASSERT_EQ(result.observations.numObservations(), 50U * 13U);
  for (std::size_t p = 0; p < 50; ++p) {
    for (std::uint32_t k = 0; k < 13; ++k) {
      const std::size_t at = result.observations.offsets[p] + k;
      EXPECT_EQ(result.observations.views[at], k);
      const float u = 49.5F + places[p].x() * 100 / (1 + static_cast<float>(k));
      const float expected = (2 * u + 39.5F) / 2;
      EXPECT_NEAR(result.observations.values(0, static_cast<Eigen::Index>(at)), expected, 0.51);  // image is rounded
    }
  }
}

TEST(Observe, EdgesCountOnlyWhereNothingElseDoes) {
  auto at_edge = openDepth();
  at_edge->edge = 255;
  ObservedView clear = makeView(0), edge = makeView(1);
  edge.depth = at_edge;
  const Scene scene = makeScene({{0, 0, 1}});
  for (const auto& views : {std::vector<ObservedView>{clear, edge}, std::vector<ObservedView>{edge, clear}}) {
    EXPECT_EQ(look(scene, views).observations.views, std::vector<std::uint32_t>{0});
  }
  ObservedView other_edge = makeView(2);
  other_edge.depth = at_edge;
  const auto only = look(scene, {edge, other_edge});
  EXPECT_EQ(only.observations.views, (std::vector<std::uint32_t>{1, 2}));
  EXPECT_EQ(look(scene, {edge}).observations.numObservations(), 1U);
  auto wall = openDepth();
  wall->depth = 0.5F;
  ObservedView hidden = makeView(3);
  hidden.depth = wall;
  EXPECT_EQ(look(scene, {edge, hidden}).observations.numObservations(), 0U) << "one against another is no evidence";
  EXPECT_EQ(look(scene, {edge, hidden, other_edge}).observations.numObservations(), 2U);
}

/// A row of points of a wall, 8 cm apart; the view sees those whose cell of the depth image is open.
std::vector<Unseen> lookAtWall(const std::vector<int>& open, std::size_t copies = 1) {
  std::vector<Eigen::Vector3f> row;
  for (int i = 0; i < 20; ++i) {
    for (std::size_t k = 0; k < copies; ++k) row.emplace_back(0.08F * static_cast<float>(i - 10) + 0.02F, 0, 4);
  }
  ObservedView view = makeView();
  auto depth = openDepth();
  depth->depth = 1;
  for (const int i : open) depth->depth.col(25 + i - 10) = 10;
  view.depth = depth;
  return look(makeScene(row), {view}).unseen;
}

TEST(Observe, PointInSightAmongHiddenOnesIsHidden) {
  const auto one = lookAtWall({10});
  EXPECT_EQ(one[10], Unseen::kHidden);
  std::vector<int> all_but_one;
  for (int i = 0; i < 20; ++i) {
    if (i != 10) all_but_one.push_back(i);
  }
  const auto most = lookAtWall(all_but_one);
  EXPECT_EQ(most[9], Unseen::kSeen);
  EXPECT_EQ(most[10], Unseen::kHidden);
  EXPECT_EQ(most[11], Unseen::kSeen);
}

TEST(Observe, CopiesOfAPointDoNotSpeakForIt) {
  for (const Unseen unseen : lookAtWall({10}, 20)) EXPECT_EQ(unseen, Unseen::kHidden);
}

TEST(Observe, WeightFallsWithDistanceGrazingAndBorder) {
  const auto weight = [](const Scene& scene) { return look(scene, {makeView()}).observations.weights.at(0); };
  const float best = weight(makeScene({{0, 0, 1}}));
  EXPECT_GT(best, 0);
  EXPECT_LE(best, 1);
  EXPECT_LT(weight(makeScene({{0, 0, 20}})), best);
  EXPECT_LT(weight(makeScene({{0.43F, 0, 1}})), best);
  Scene grazing = makeScene({{0, 0, 1}});
  grazing.surfels.normals.col(0) = Eigen::Vector3f(0.995F, 0, 0.1F);
  EXPECT_LT(weight(grazing), 0.5F * best);
}

TEST(Observe, RefusesWhatDoesNotFit) {
  const Scene scene = makeScene({{0, 0, 1}});
  const auto expect_refused = [&](const ObservedView& view) {
    EXPECT_THROW(look(scene, {makeView(), view}), std::invalid_argument);
  };
  ObservedView view = makeView(1);
  view.image = std::make_shared<cv::Mat>(cv::Mat::zeros(80, 99, CV_8UC3));
  expect_refused(view);
  view.image = std::make_shared<cv::Mat>(cv::Mat::zeros(80, 100, CV_8UC1));
  expect_refused(view);
  view.image = std::make_shared<cv::Mat>(cv::Mat::zeros(80, 100, CV_16SC3));
  expect_refused(view);
  view = makeView(1);
  view.mask = std::make_shared<cv::Mat>(cv::Mat::zeros(40, 100, CV_8UC1));
  expect_refused(view);
  view.mask = std::make_shared<cv::Mat>(cv::Mat::zeros(80, 100, CV_8UC3));
  expect_refused(view);
  view = makeView(1);
  view.exposure.gain = arrayOf({1, 1});
  expect_refused(view);
  view = makeView(1);
  view.depth = nullptr;
  expect_refused(view);
  view = makeView(1);
  view.map_from_camera.translation().x() = std::nan("");
  expect_refused(view);
  ObserveParams params;
  params.max_views = 0;
  EXPECT_THROW(look(scene, {makeView()}, params), std::invalid_argument);
  Scene short_scene = makeScene({{0, 0, 1}, {0, 0, 2}});
  short_scene.surfels.radii.resize(1);
  EXPECT_THROW(look(short_scene, {makeView()}), std::invalid_argument);
}

}  // namespace
}  // namespace cloud_colorizer
