// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause

#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <set>

#include "simulation/truth.hpp"

namespace cloud_colorizer::simulation {
namespace {

constexpr double kDegree = 3.14159265358979 / 180;

Options quiet() {
  Options o;
  o.frames = 3;
  o.width = 64;
  o.height = 40;
  o.beams = 16;
  o.azimuths = 60;
  o.exposure = o.white_balance = o.pixel_noise = o.range_noise = 0;
  o.pose_noise_deg = o.pose_noise_m = o.extrinsic_noise_deg = o.extrinsic_noise_m = 0;
  return o;
}

StreetOptions coarse(const Options& options) {
  StreetOptions street = streetOf(options);
  street.lighting.shadow_cell = 0.5;
  return street;
}

double angleBetween(const Eigen::Isometry3d& a, const Eigen::Isometry3d& b) {
  return Eigen::AngleAxisd(a.linear().transpose() * b.linear()).angle();
}

TEST(Options, TextIsParsedOrRefused) {
  Options o;
  setOption(o, "frames", "7");
  setOption(o, "moving-car", "");
  setOption(o, "time-offset", "-0.05");
  EXPECT_EQ(o.frames, 7);
  EXPECT_TRUE(o.moving_car);
  EXPECT_EQ(o.time_offset, -0.05);
  EXPECT_THROW(setOption(o, "frames", "7.5"), std::invalid_argument);
  EXPECT_THROW(setOption(o, "frames", ""), std::invalid_argument);
  EXPECT_THROW(setOption(o, "frame", "7"), std::invalid_argument);
  EXPECT_THROW(setOption(o, "moving-car", "maybe"), std::invalid_argument);
}

TEST(Options, EveryValueOutOfRangeIsRefused) {
  const std::vector<std::pair<std::string, std::string>> bad = {
      {"seed", "-1"},         {"frames", "0"},          {"cameras", "7"},
      {"rate", "0"},          {"speed", "-1"},          {"width", "0"},
      {"height", "9000"},     {"pixel-noise", "-1"},    {"exposure", "0.9"},
      {"vignetting", "1"},    {"white-balance", "2"},   {"jpeg-quality", "0"},
      {"readout", "1"},       {"image-transport", "x"}, {"beams", "0"},
      {"azimuths", "0"},      {"lidar-range", "0"},     {"range-noise", "-1"},
      {"pose-noise-m", "-1"}, {"pose-noise-deg", "-1"}, {"extrinsic-noise-m", "-1"},
      {"time-offset", "1"},   {"voxel-size", "-1"},     {"extrinsic-noise-deg", "-1"},
      {"passes", "0"},        {"stand", "-1"},          {"van-ahead", "-1"},
      {"pedestrians", "-1"},  {"leaves", "-1"},         {"beam-divergence", "-1"},
      {"drift", "-1"},        {"gloss", "-1"}};
  EXPECT_EQ(bad.size() + 5, describeOptions(Options{}).size());  // all but the switches and the preset
  for (const auto& [name, value] : bad) {
    Options o;
    setOption(o, name, value);
    EXPECT_THROW(o.check(), std::invalid_argument) << name;
  }
}

TEST(Options, PresetSetsAllOthers) {
  Options o = quiet();
  setOption(o, "preset", "vehicle");
  EXPECT_EQ(o.preset, "vehicle");
  EXPECT_GT(o.drift, 0);
  EXPECT_EQ(o.width, Options{}.width);
  EXPECT_LT(presetOptions("cheap").beams, o.beams);
  EXPECT_EQ(presetOptions("clean").van_ahead, 0);
  EXPECT_THROW(setOption(o, "preset", "truck"), std::invalid_argument);
  for (const char* name : {"clean", "vehicle", "cheap"}) EXPECT_NO_THROW(presetOptions(name).check()) << name;
}

TEST(Options, SceneFileGivesTheOptionsBack) {
  const std::string path = ::testing::TempDir() + "/scene_test.yaml";
  Options o = quiet();
  o.seed = 12;
  o.moving_car = true;
  o.time_offset = -0.0123;
  writeSceneFile(Drive(o), path);
  const auto written = describeOptions(o);
  const auto read = describeOptions(readSceneFile(path));
  for (std::size_t i = 0; i < written.size(); ++i) EXPECT_EQ(read[i].value, written[i].value) << written[i].name;
  std::ofstream(path) << "something: else\n";
  EXPECT_THROW(readSceneFile(path), std::runtime_error);
  EXPECT_THROW(readSceneFile(path + ".missing"), std::runtime_error);
  std::filesystem::remove(path);
}

TEST(Drive, WithoutNoiseTheGivenPosesAreTrue) {
  const Drive drive(quiet());
  for (double t = 0; t < drive.duration(); t += 0.01) {
    EXPECT_TRUE(drive.mapFromBaseGiven(t).isApprox(drive.mapFromBase(t), 1e-15));
  }
  for (const DriveCamera& c : drive.cameras())
    EXPECT_TRUE(c.base_from_camera.isApprox(c.base_from_camera_given, 1e-15));
  EXPECT_TRUE((drive.gain(1, 2) == 1).all());
}

TEST(Drive, NoiseHasTheChosenSize) {
  Options o = quiet();
  o.frames = 600;
  o.pose_noise_deg = 0.06;
  o.pose_noise_m = 0.008;
  o.extrinsic_noise_deg = 0.12;
  o.extrinsic_noise_m = 0.006;
  const Drive drive(o);
  double angle = 0, distance = 0, product = 0;
  Eigen::Vector3d before(0, 0, 0);
  for (int frame = 0; frame < o.frames; ++frame) {
    const Eigen::Isometry3d given = drive.mapFromBaseGiven(drive.scanTime(frame));
    const Eigen::Isometry3d error = drive.mapFromBase(drive.scanTime(frame)).inverse() * given;
    angle += std::pow(Eigen::AngleAxisd(error.linear()).angle() / kDegree, 2);
    distance += error.translation().squaredNorm();
    product += before.dot(error.translation());
    before = error.translation();
  }
  EXPECT_NEAR(std::sqrt(angle / 3 / o.frames), 0.06, 0.006);
  EXPECT_NEAR(std::sqrt(distance / 3 / o.frames), 0.008, 0.0008);
  EXPECT_LT(product / distance, 0.45);  // frames 0.1 s apart hardly share their error
  for (const DriveCamera& c : drive.cameras()) {
    EXPECT_NEAR(angleBetween(c.base_from_camera, c.base_from_camera_given) / kDegree, 0.12 * std::sqrt(3), 1e-6);
    EXPECT_NEAR((c.base_from_camera.translation() - c.base_from_camera_given.translation()).norm(),
                0.006 * std::sqrt(3), 1e-9);
  }
}

TEST(Drive, SecondPassGoesBackAndAStopStandsStill) {
  Options o = quiet();
  o.frames = 40;
  o.passes = 2;
  o.stand = 1;
  const Drive drive(o);
  const auto way = [&](double t) { return drive.mapFromBase(0.5 + t).translation().x(); };
  EXPECT_NEAR(way(0), 0, 1e-9);
  EXPECT_NEAR(way(0.75), 7.5, 1e-9);
  EXPECT_NEAR(way(1.7), 7.5, 1e-9);
  EXPECT_NEAR(way(2.5), 15, 1e-9);
  EXPECT_NEAR(way(4), 0, 1e-9);
  EXPECT_TRUE(drive.mapFromBase(1.4).isApprox(drive.mapFromBase(2.1), 1e-12));
}

TEST(Drive, DriftIsSlow) {
  Options o = quiet();
  o.frames = 2000;
  o.drift = 0.05;
  const Drive drive(o);
  double squares = 0, fast = 0;
  for (int frame = 0; frame < o.frames; ++frame) {
    const auto error = [&](double t) -> Eigen::Vector3d {
      return (drive.mapFromBase(t).inverse() * drive.mapFromBaseGiven(t)).translation();
    };
    squares += error(drive.scanTime(frame)).squaredNorm();
    fast += (error(drive.scanTime(frame)) - error(drive.scanTime(frame) + 0.1)).squaredNorm();
  }
  EXPECT_NEAR(std::sqrt(squares / 3 / o.frames), 0.05, 0.01);
  EXPECT_LT(std::sqrt(fast / 3 / o.frames), 0.01);
}

TEST(Lidar, WideBeamsScatterWithSlantAndMixAtEdges) {
  Options o = quiet();
  o.frames = 1;
  o.beams = 48;
  o.azimuths = 1200;
  o.beam_divergence = 4;
  const Drive drive(o);
  const Scene scene = makeStreet(coarse(o));
  double straight = 0, slanted = 0;
  int num_straight = 0, num_slanted = 0, mixed = 0;
  for (const Return& r : takeScan(scene, drive, 0)) {
    const Eigen::Vector3d point = drive.mapFromBase(drive.scanTime(0)) * drive.baseFromLidar() * r.point.cast<double>();
    const auto surface = scene.closestPoint(point, 1);
    const double off = surface ? surface->distance : 1;
    mixed += off > 0.1 ? 1 : 0;
    if (!surface || off > 0.1 || scene.solids()[static_cast<std::size_t>(r.truth.solid)].isMoving()) continue;
    const double range = r.point.norm(), slant = std::abs((r.truth.point - point).norm()) / range;
    const double cosine = std::abs(r.truth.normal.dot(drive.mapFromBase(drive.scanTime(0)).linear() *
                                                      drive.baseFromLidar().linear() * r.point.cast<double>())) /
                          range;
    if (cosine > 0.8) straight += slant * slant, ++num_straight;
    if (cosine < 0.2) slanted += slant * slant, ++num_slanted;
  }
  ASSERT_GT(num_straight, 30);
  ASSERT_GT(num_slanted, 30);
  EXPECT_GT(slanted / num_slanted, 4 * straight / num_straight);
  EXPECT_GT(mixed, 3);
}

TEST(Street, VanDrivesAheadAndPedestriansWalk) {
  Options o = quiet();
  o.frames = 60;
  o.passes = 2;
  o.stand = 1;
  o.van_ahead = 9;
  o.pedestrians = 4;
  const Drive drive(o);
  const Scene scene = makeStreet(coarse(o));
  for (const double t : {0.6, 2.0, 2.4, 4.0, 6.0}) {
    const Eigen::Vector3d eye = drive.mapFromBase(t) * Eigen::Vector3d(0, 0, 0.8);
    const auto hit = scene.castRay({eye.x(), -1.5, 0.8}, Eigen::Vector3d::UnitX(), t);
    ASSERT_TRUE(hit);
    EXPECT_TRUE(scene.solids()[static_cast<std::size_t>(hit->solid)].isMoving());
    EXPECT_NEAR(hit->distance, 9 - 2.1, 0.15) << t;
  }
  std::set<int> movers;
  for (const Solid& solid : scene.solids()) {
    if (solid.isMoving()) movers.insert(solid.primitive().object);
  }
  EXPECT_EQ(movers.size(), 5U);
}

TEST(Drive, PoseNoiseIsSmoothBetweenSamplesOfTf) {
  Options o = quiet();
  o.pose_noise_m = 0.008;
  const Drive drive(o);
  for (double t = 0.2; t < 0.7; t += 0.01) {
    const Eigen::Vector3d middle =
        (drive.mapFromBaseGiven(t).translation() + drive.mapFromBaseGiven(t + 0.01).translation()) / 2;
    EXPECT_LT((middle - drive.mapFromBaseGiven(t + 0.005).translation()).norm(), 3e-4);
  }
}

TEST(Drive, GainStaysWithinItsBoundsAndUsesThem) {
  Options o = quiet();
  o.frames = 200;
  o.exposure = 0.12;
  const Drive drive(o);
  float low = 1, high = 1;
  for (int frame = 0; frame < o.frames; ++frame) {
    low = std::min(low, drive.gain(0, frame).minCoeff());
    high = std::max(high, drive.gain(0, frame).maxCoeff());
  }
  EXPECT_GE(low, 0.88F - 1e-5F);
  EXPECT_LE(high, 1.12F + 1e-5F);
  EXPECT_GT(high - low, 0.2F);
}

TEST(Drive, TimeOffsetIsInTheStampsOfImagesAlone) {
  Options o = quiet();
  const Drive before(o);
  o.time_offset = 0.05;
  const Drive after(o);
  EXPECT_EQ(after.imageStamp(0, 1) - before.imageStamp(0, 1), 50000000);
  EXPECT_EQ(after.stamp(1), before.stamp(1));
  EXPECT_TRUE(after.mapFromCamera(0, 1).isApprox(before.mapFromCamera(0, 1), 1e-15));
  const TrueView view = trueViewOfStamp(after, 0, static_cast<double>(after.imageStamp(0, 1)) * 1e-9);
  EXPECT_TRUE(view.map_from_camera.isApprox(after.mapFromCamera(0, 1), 1e-15));
  EXPECT_THROW(trueViewOfStamp(after, 0, static_cast<double>(before.imageStamp(0, 1)) * 1e-9), std::invalid_argument);
  EXPECT_THROW(trueViewOfStamp(after, 2, 0), std::invalid_argument);
}

TEST(Drive, EveryPixelOfEveryCameraHasABearing) {
  Options o = quiet();
  o.cameras = 6;
  const Drive drive(o);
  for (const DriveCamera& c : drive.cameras()) {
    const PixelRays rays(c.camera);
    for (int v = 0; v < o.height; ++v) {
      for (int u = 0; u < o.width; ++u) {
        ASSERT_NEAR(rays.bearing(u, v).norm(), 1, 1e-5) << c.name << " " << u << " " << v;
        const auto pixel = c.camera.project(3 * rays.bearing(u, v));
        if (u == 0 || v == 0 || u == o.width - 1 || v == o.height - 1) continue;  // may round out of the image
        ASSERT_TRUE(pixel);
        EXPECT_LT((*pixel - Eigen::Vector2f(static_cast<float>(u), static_cast<float>(v))).norm(), 0.05F);
      }
    }
  }
}

TEST(Render, PixelIsTheColorWhereItsRayEnds) {
  const Options o = quiet();
  const Drive drive(o);
  const Scene scene = makeStreet(coarse(o));
  const PixelRays rays(drive.cameras()[0].camera);
  const Eigen::Isometry3d pose = drive.mapFromCamera(0, 1);
  const cv::Mat3f image = renderImage(
      scene, rays, [&](double) { return pose; }, drive.imageTime(0, 1));
  double error = 0;
  for (int v = 0; v < o.height; ++v) {
    for (int u = 0; u < o.width; ++u) {
      const Eigen::Vector3d direction = (pose.linear() * rays.bearing(u, v).cast<double>()).normalized();
      const auto hit = scene.castRay(pose.translation(), direction, drive.imageTime(0, 1));
      const auto footprint = hit ? static_cast<float>(hit->distance) * rays.pixelAngle() : 0.F;
      const Color color = hit ? scene.trueColor(*hit, footprint) : scene.skyColor(direction);
      error += std::abs(static_cast<double>(color[0] - image(v, u)[0]));
    }
  }
  EXPECT_LT(error / (o.width * o.height), 12);  // supersampled edges differ; a wrong pose would give 40 and more
}

TEST(Render, ExposureScalesDarkensCornersAndAddsNoise) {
  const cv::Mat3f grey(101, 101, cv::Vec3f(100, 100, 100));
  const cv::Mat3b plain = exposeImage(grey, Color(1.1F, 1, 0.5F), 0.4, 0, 1);
  EXPECT_EQ(plain(50, 50), cv::Vec3b(110, 100, 50));
  EXPECT_NEAR(plain(0, 0)[1], 60, 2);
  EXPECT_EQ(exposeImage(grey, Color(3, 3, 3), 0, 0, 1)(5, 5), cv::Vec3b(255, 255, 255));
  const cv::Mat3b noisy = exposeImage(grey, Color(1, 1, 1), 0, 2, 7);
  double sum = 0, squares = 0;
  for (const cv::Vec3b& pixel : noisy) {
    sum += pixel[0] - 100;
    squares += (pixel[1] - 100) * (pixel[1] - 100);
  }
  EXPECT_NEAR(sum / static_cast<double>(noisy.total()), 0, 0.1);
  EXPECT_NEAR(std::sqrt(squares / static_cast<double>(noisy.total())), 2.02, 0.08);
  EXPECT_NE(noisy(3, 3), exposeImage(grey, Color(1, 1, 1), 0, 2, 8)(3, 3));
}

TEST(Scan, PointsOfTheSweepLieOnTheSurfaceInTheFrameOfItsStamp) {
  const Options o = quiet();
  const Drive drive(o);
  const Scene scene = makeStreet(coarse(o));
  const auto returns = takeScan(scene, drive, 1);
  ASSERT_GT(returns.size(), 500U);
  const Eigen::Isometry3d map_from_lidar = drive.mapFromBase(drive.scanTime(1)) * drive.baseFromLidar();
  for (const Return& r : returns) {
    const auto surface = scene.closestPoint(map_from_lidar * r.point.cast<double>(), 0.1);
    ASSERT_TRUE(surface);
    EXPECT_LT(surface->distance, 1e-4);
    EXPECT_GE(r.intensity, 0);
    EXPECT_LE(r.intensity, 255);
    EXPECT_LT(r.time, 0.1F);
    EXPECT_LT(r.ring, o.beams);
  }
  EXPECT_GT(returns.back().time, 0.09F);
}

TEST(Scan, RangeNoiseHasTheChosenSize) {
  Options o = quiet();
  o.azimuths = 300;
  const Scene scene = makeStreet(coarse(o));
  const auto clean = takeScan(scene, Drive(o), 0);
  o.range_noise = 0.015;
  const auto noisy = takeScan(scene, Drive(o), 0);
  ASSERT_EQ(clean.size(), noisy.size());
  double squares = 0;
  for (std::size_t i = 0; i < clean.size(); ++i)
    squares += static_cast<double>((clean[i].point - noisy[i].point).squaredNorm());
  EXPECT_NEAR(std::sqrt(squares / static_cast<double>(clean.size())), 0.015, 0.001);
}

TEST(Scan, MovingCarIsSeenAndIsNotTruth) {
  Options o = quiet();
  o.moving_car = true;
  o.azimuths = 400;
  const Scene scene = makeStreet(coarse(o));
  const auto returns = takeScan(scene, Drive(o), 1);
  std::size_t num_moving = 0;
  for (const Return& r : returns) num_moving += scene.solids()[static_cast<std::size_t>(r.truth.solid)].isMoving();
  EXPECT_GT(num_moving, 20U);
  TruthCloud cloud(0);
  cloud.add(scene, returns);
  EXPECT_EQ(cloud.size(), returns.size() - num_moving);
}

/// A camera at the origin looks along +x at a wall at x = 10 that a smaller wall at x = 5 hides in part.
class TwoWalls : public ::testing::Test {
 protected:
  static Primitive wall(double x, double half_width) {
    Primitive p;
    p.profile = {{-0.1, -2}, {0.1, -2}, {0.1, 2}, {-0.1, 2}};
    p.half_length = half_width;
    p.map_from_local.translation().x() = x;
    return p;
  }
  static Intrinsics pinhole() {
    Intrinsics k;
    k.width = 100, k.height = 100, k.fx = k.fy = 50, k.cx = k.cy = 49.5;
    return k;
  }
  TrueView viewAt(double x, double y) const {
    TrueView view{camera_, Eigen::Isometry3d::Identity(), 0};
    view.map_from_camera.linear() << 0, 0, 1, -1, 0, 0, 0, -1, 0;
    view.map_from_camera.translation() = Eigen::Vector3d(x, y, 0);
    return view;
  }
  PointTruth truthAt(const Eigen::Vector3d& point, const std::vector<TrueView>& views) const {
    return trueVisibility(scene_, point, views, TruthOptions{}).at(0);
  }

  Camera camera_{pinhole()};
  Scene scene_{{wall(5, 1), wall(10, 6)}, [] {
                 Lighting lighting;
                 lighting.shadow_cell = 0;
                 return lighting;
               }()};
};

TEST_F(TwoWalls, FreeLineOfSightMeansVisible) {
  const PointTruth truth = truthAt({9.88, 4, 0.5}, {viewAt(0, 0)});  // 2 cm before the surface
  EXPECT_EQ(truth.truth, Truth::kVisible);
  EXPECT_NEAR(truth.surface_distance, 0.02, 1e-6);
  EXPECT_EQ(truth.num_visible, 1);
  EXPECT_FALSE(truth.is_near_edge);
}

TEST_F(TwoWalls, NoiseBehindTheSurfaceDoesNotHideThePoint) {
  EXPECT_EQ(truthAt({9.94, 4, 0.5}, {viewAt(0, 0)}).truth, Truth::kVisible);
}

TEST_F(TwoWalls, PointBehindTheFirstWallIsHidden) {
  EXPECT_EQ(truthAt({9.9, 0.5, 0.5}, {viewAt(0, 0)}).truth, Truth::kHidden);
  EXPECT_EQ(truthAt({9.9, 0.5, 0.5}, {viewAt(0, 0), viewAt(0, 5)}).truth, Truth::kVisible);
}

TEST_F(TwoWalls, BackOfAWallIsHidden) {
  EXPECT_EQ(truthAt({10.1, 4, 0.5}, {viewAt(0, 0)}).truth, Truth::kHidden);
}

TEST_F(TwoWalls, OutsideOfImageOrRangeIsOutOfView) {
  EXPECT_EQ(truthAt({9.9, 4, 0.5}, {viewAt(20, 0)}).truth, Truth::kOutOfView);
  EXPECT_EQ(truthAt({9.9, 4, 0.5}, {viewAt(-40, 0)}).truth, Truth::kOutOfView);
  EXPECT_EQ(truthAt({9.9, 4, 0.5}, {}).truth, Truth::kOutOfView);
}

TEST_F(TwoWalls, PointInTheAirHasNoTruth) {
  EXPECT_EQ(truthAt({8, 0, 0}, {viewAt(0, 0)}).truth, Truth::kNoSurface);
}

TEST_F(TwoWalls, PointAtTheEndOfAWallIsNearAnEdge) {
  EXPECT_TRUE(truthAt({4.9, 0.99, 0}, {viewAt(0, 0)}).is_near_edge);
}

TEST_F(TwoWalls, NoPointsNoTruth) {
  EXPECT_TRUE(trueVisibility(scene_, Eigen::Matrix3Xd(3, 0), {viewAt(0, 0)}, TruthOptions{}).empty());
}

TEST_F(TwoWalls, NumberOfThreadsDoesNotChangeTheTruth) {
  const Eigen::Matrix3Xd points =
      (Eigen::Matrix3Xd::Random(3, 3000).array().colwise() * Eigen::Array3d(0.3, 6, 2)).colwise() +
      Eigen::Array3d(9.8, 0, 0);
  TruthOptions options;
  options.num_threads = 1;
  const auto one = trueVisibility(scene_, points, {viewAt(0, 0), viewAt(0, 3)}, options);
  options.num_threads = 3;
  const auto three = trueVisibility(scene_, points, {viewAt(0, 0), viewAt(0, 3)}, options);
  for (std::size_t i = 0; i < one.size(); ++i) {
    EXPECT_EQ(one[i].truth, three[i].truth);
    EXPECT_EQ(one[i].num_visible, three[i].num_visible);
  }
}

TEST_F(TwoWalls, TruthCloudIsThinnedAndWritten) {
  std::vector<Return> returns(3);
  returns[0].truth = *scene_.castRay({0, 4, 0}, {1, 0, 0});
  returns[1].truth = *scene_.castRay({0, 4.01, 0}, {1, 0, 0});
  returns[2].truth = *scene_.castRay({0, 4.5, 0}, {1, 0, 0});
  TruthCloud cloud(0.05);
  cloud.add(scene_, returns);
  EXPECT_EQ(cloud.size(), 2U);
  const std::string path = ::testing::TempDir() + "/truth_test.ply";
  cloud.write(path);
  std::ifstream file(path, std::ios::binary);
  const std::string text((std::istreambuf_iterator<char>(file)), {});
  EXPECT_NE(text.find("element vertex 2\n"), std::string::npos);
  EXPECT_EQ(text.size(), text.find("end_header\n") + 11 + 2 * 27);
  std::filesystem::remove(path);
  EXPECT_THROW(cloud.write("/nonexistent/truth.ply"), std::runtime_error);
}

}  // namespace
}  // namespace cloud_colorizer::simulation
