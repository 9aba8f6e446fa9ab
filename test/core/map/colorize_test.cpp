// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause
#include "cloud_colorizer/map/colorize.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <limits>
#include <map>
#include <nlohmann/json.hpp>
#include <opencv2/imgcodecs.hpp>
#include <random>
#include <stdexcept>
#include <tuple>

#include "cloud_colorizer/base/check.hpp"
#include "cloud_colorizer/cloud/cloud_io.hpp"
#include "cloud_colorizer/exchange/colmap.hpp"
#include "cloud_colorizer/exchange/export_model.hpp"
#include "core/scratch.hpp"

namespace cloud_colorizer {
namespace {

using Eigen::Index;

/// Walls at given x, y from -4 to 4 m, z from 0 to 4 m, seen by cameras that look along +x.
constexpr double kHalfWidth = 4, kHeight = 4;

Cloud wall(double x, double spacing) {
  const auto columns = static_cast<Index>(2 * kHalfWidth / spacing), rows = static_cast<Index>(kHeight / spacing);
  Cloud cloud;
  cloud.fields = {{"intensity", FieldType::kFloat32, 1}};
  cloud.positions.resize(3, columns * rows);
  for (Index i = 0; i < columns * rows; ++i) {
    const double along = static_cast<double>(i % columns) + 0.5, up = static_cast<double>(i / columns) + 0.5;
    cloud.positions.col(i) << x, -kHalfWidth + along * spacing, up * spacing;
  }
  cloud.records.resize(static_cast<std::size_t>(columns * rows) * 4);
  return cloud;
}

Eigen::Isometry3d cameraAt(double x, double y, double z) {
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
  pose.linear() << 0, 0, 1, -1, 0, 0, 0, -1, 0;  // optical z along x, x to the right, y down
  pose.translation() << x, y, z;
  return pose;
}

/// What a camera at (cx, cy, cz) sees of a wall at x with a smooth pattern, times a gain. RGB.
std::vector<std::uint8_t> imageOfWall(const Intrinsics& k, const Eigen::Vector3d& camera, double x, double gain) {
  cv::Mat3b bgr(k.height, k.width);
  for (int v = 0; v < k.height; ++v) {
    for (int u = 0; u < k.width; ++u) {
      const double y = camera.y() - (u - k.cx) / k.fx * (x - camera.x());
      const double z = camera.z() - (v - k.cy) / k.fy * (x - camera.x());
      const double pattern = gain * (120 + 50 * std::sin(2 * y) * std::cos(3 * z));
      bgr(v, u) = cv::Vec3b(cv::saturate_cast<std::uint8_t>(0.5 * pattern), cv::saturate_cast<std::uint8_t>(pattern),
                            cv::saturate_cast<std::uint8_t>(1.2 * pattern));
    }
  }
  std::vector<std::uint8_t> png;
  cv::imencode(".png", bgr, png);
  return png;
}

class Colorize : public ::testing::Test {
 protected:
  Colorize() {
    intrinsics_.width = 320, intrinsics_.height = 240;
    intrinsics_.fx = intrinsics_.fy = 200;
    intrinsics_.cx = 159.5, intrinsics_.cy = 119.5;
    record_.voxel_size = 0;
    record_.min_range = 0;
    record_.max_range = 1e6;
    record_.tile_size = 1;
    params_.colorize.method = Method::kPaper;
  }

  /// Walls at `xs`; one view from each of `cameras`, of the wall at `seen`, with gains 1, 1.1, 1.2, ...
  /// `scale`: of all lengths.
  Recording record(const std::string& name, const std::vector<double>& xs, double spacing,
                   const std::vector<Eigen::Vector3d>& cameras, double seen, double scale = 1) {
    RecordParams scaled = record_;
    scaled.tile_size *= scale;
    Recorder recorder(scratch_ / name, "map", scaled);
    for (const double x : xs) {
      Cloud cloud = wall(x, spacing);
      cloud.positions *= scale;
      recorder.addCloud(cloud, Eigen::Isometry3d::Identity());
    }
    const auto camera = recorder.setCamera("camera_0", intrinsics_);
    double gain = 1;
    for (const auto& at : cameras) {
      Eigen::Isometry3d pose = cameraAt(at.x(), at.y(), at.z());
      pose.translation() *= scale;
      recorder.addView(camera, gain, pose, imageOfWall(intrinsics_, at, seen, gain), "png");
      gain += 0.1;
    }
    return recorder.snapshot();
  }

  Cloud colored(const Recording& recording) const {
    Cloud all;
    forEachColoredTile(recording, params_, true, [&](const Cloud& tile) {
      const Index before = all.positions.cols();
      all.fields = tile.fields;
      all.positions.conservativeResize(3, before + tile.positions.cols());
      all.positions.rightCols(tile.positions.cols()) = tile.positions;
      all.records.insert(all.records.end(), tile.records.begin(), tile.records.end());
    });
    return all;
  }

  ScratchDirectory scratch_;
  Intrinsics intrinsics_;
  RecordParams record_;
  Params params_;
};

/// Red, green, blue of point i; its record is intensity, rgb, view_count, color_stddev.
Eigen::Vector3d colorOf(const Cloud& cloud, Index i) {
  const std::uint8_t* rgb = cloud.records.data() + static_cast<std::size_t>(i) * recordSize(cloud.fields) + 4;
  return {static_cast<double>(rgb[2]), static_cast<double>(rgb[1]), static_cast<double>(rgb[0])};
}
int viewCountOf(const Cloud& cloud, Index i) {
  std::uint16_t count = 0;
  std::memcpy(&count, cloud.records.data() + static_cast<std::size_t>(i) * recordSize(cloud.fields) + 8, 2);
  return count;
}
std::string bytesOf(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

const std::vector<Eigen::Vector3d> kThreeCameras = {{0, -1, 2}, {0, 0, 2}, {0, 1, 2}};

TEST_F(Colorize, WrittenModelHasTheCorrectedPoses) {
  Recorder recorder(scratch_ / "r", "map", record_);
  recorder.addCloud(wall(5, 0.05), Eigen::Isometry3d::Identity());
  const auto camera = recorder.setCamera("camera_0", intrinsics_);
  const Eigen::Isometry3d error(Eigen::AngleAxisd(0.01, Eigen::Vector3d::UnitY()));  // 2 px
  for (int i = 0; i < 5; ++i) {
    const Eigen::Vector3d at(0, -1 + 0.5 * i, 2);
    const Eigen::Isometry3d pose = cameraAt(at.x(), at.y(), at.z());
    recorder.addView(camera, 10 * i, i == 2 ? pose * error : pose, imageOfWall(intrinsics_, at, 5, 1), "png");
  }
  const Recording recording = recorder.snapshot();
  params_.colorize.method = Method::kDefault;
  params_.alignment.pose_rotation_prior = 0.5;
  colorize(recording, params_, {});
  exportModel(recording, params_, scratch_ / "model");
  const ColmapModel aligned = readColmapModel(scratch_ / "model");
  params_.colorize.method = Method::kPaper;  // which does not align
  exportModel(recording, params_, scratch_ / "model");
  const ColmapModel recorded = readColmapModel(scratch_ / "model");
  // Pixels, because a shift of the camera looks like a turn. Where the middle view sees the middle of the wall:
  const auto pixel = [&](const Eigen::Isometry3d& map_from_camera) {
    return Camera(intrinsics_).linearize(map_from_camera.inverse() * Eigen::Vector3d(5, 0, 2))->pixel;
  };
  const Eigen::Vector2d truth = pixel(cameraAt(0, 0, 2));
  EXPECT_NEAR((pixel(recorded.images[2].map_from_camera) - truth).norm(), 2, 0.05);
  EXPECT_LT((pixel(aligned.images[2].map_from_camera) - truth).norm(), 0.5);
}

TEST_F(Colorize, APointHasTheColourOfTheWall) {
  const Recording recording = record("r", {5}, 0.05, {{0, 0, 2}}, 5);
  params_.colorize.method = Method::kMean;
  const ColorizeSummary summary = colorize(recording, params_, {});
  const Cloud cloud = colored(recording);
  ASSERT_EQ(cloud.positions.cols(), static_cast<Index>(recording.numPoints()));
  std::size_t seen = 0;
  for (Index i = 0; i < cloud.positions.cols(); ++i) {
    if (viewCountOf(cloud, i) == 0) continue;
    ++seen;
    const double pattern = 120 + 50 * std::sin(2 * cloud.positions(1, i)) * std::cos(3 * cloud.positions(2, i));
    EXPECT_NEAR(colorOf(cloud, i)[1], pattern, 4);
    EXPECT_NEAR(colorOf(cloud, i)[2], 0.5 * pattern, 4);
  }
  EXPECT_EQ(seen, summary.num_colored);
  EXPECT_GT(seen, recording.numPoints() * 9 / 10);
}

TEST_F(Colorize, AWallInAnotherChunkHides) {
  const Recording recording = record("r", {5, 15}, 0.04, {{0, 0, 2}}, 5);
  params_.chunks.max_chunk_points = 1000;
  params_.chunks.overlap = 0;
  const ColorizeSummary summary = colorize(recording, params_, {});
  const Cloud cloud = colored(recording);
  std::size_t behind_colored = 0;
  for (Index i = 0; i < cloud.positions.cols(); ++i) {
    if (cloud.positions(0, i) > 10 && viewCountOf(cloud, i) > 0) ++behind_colored;
  }
  EXPECT_EQ(behind_colored, 0U);
  EXPECT_GT(summary.by_reason[static_cast<std::size_t>(Unseen::kHidden)], recording.numPoints() * 4 / 10);
}

TEST_F(Colorize, ASceneOfAnotherScaleHasTheSameColours) {
  params_.colorize.method = Method::kDefault;
  const auto colors_at = [&](const std::string& name, double scale) {
    const Recording recording = record(name, {5, 5.6}, 0.06, kThreeCameras, 5, scale);
    colorize(recording, params_, {});
    std::map<std::tuple<long, long, long>, Eigen::Vector3d> colors;  // by place in cm of the unscaled scene
    const Cloud cloud = colored(recording);
    for (Index i = 0; i < cloud.positions.cols(); ++i) {
      if (viewCountOf(cloud, i) == 0) continue;
      const Eigen::Vector3d at = cloud.positions.col(i) * (100 / scale);
      colors[{std::lround(at.x()), std::lround(at.y()), std::lround(at.z())}] = colorOf(cloud, i);
    }
    return colors;
  };
  const auto expected = colors_at("r", 1);
  for (const double scale : {0.01, 100.0}) {
    const auto colors = colors_at("r" + std::to_string(scale), scale);
    std::size_t alike = 0;
    for (const auto& [at, color] : colors) {
      const auto found = expected.find(at);
      alike += found != expected.end() && (found->second - color).cwiseAbs().maxCoeff() <= 2 ? 1 : 0;
    }
    EXPECT_GT(alike, expected.size() * 99 / 100) << scale;
    EXPECT_LE(colors.size(), expected.size() * 101 / 100) << scale;
  }
}

TEST_F(Colorize, WhatTheScanOfThatMomentSawThroughHidesNothingAndTakesNoColour) {
  const auto colored_counts = [&](double scan_stamp, bool use_scans) {
    const std::string name = "r" + std::to_string(scan_stamp) + std::to_string(use_scans);
    record(name, {5, 15}, 0.04, {{0, 0, 2}}, 15);  // the view is at stamp 1
    {
      Eigen::Matrix3Xd returns = wall(15, 0.04).positions;
      returns.row(2).array() -= 2;
      const Eigen::Isometry3d sensor(Eigen::Translation3d(0, 0, 2));
      Recorder(scratch_ / name, "map", record_).addScan("lidar", scan_stamp, returns, sensor);
    }
    params_.record.scan_resolution = use_scans ? 0.5 : 0;
    const Recording recording = Recording::open(scratch_ / name);
    const ColorizeSummary summary = colorize(recording, params_, {});
    const Cloud cloud = colored(recording);
    std::size_t far = 0, near = 0;  // the near wall where the scan looked
    for (Index i = 0; i < cloud.positions.cols(); ++i) {
      const Eigen::Vector3d point = cloud.positions.col(i);
      if (viewCountOf(cloud, i) == 0) continue;
      if (point.x() > 10) ++far;
      if (point.x() < 10 && std::abs(point.y()) < 1 && std::abs(point.z() - 2) < 0.4) ++near;
    }
    return std::make_tuple(far, near, summary.by_reason[static_cast<std::size_t>(Unseen::kAbsent)]);
  };
  const std::size_t wall_points = record("whole", {15}, 0.04, {}, 15).numPoints();
  const auto [far, near, gone] = colored_counts(1.1, true);
  EXPECT_GT(far, wall_points * 9 / 10);
  EXPECT_EQ(near, 0U);
  EXPECT_GT(gone, 1000U);
  const auto [far_later, near_later, gone_later] = colored_counts(2, true);  // a scan of another time
  EXPECT_LT(far_later, wall_points / 20);
  EXPECT_GT(near_later, 900U);
  EXPECT_EQ(gone_later, 0U);
  const auto [far_without, near_without, gone_without] = colored_counts(1.1, false);
  EXPECT_EQ(std::make_tuple(far_without, near_without, gone_without),
            std::make_tuple(far_later, near_later, gone_later));
}

TEST_F(Colorize, WhatStoodWhereACameraHasBeenHidesNothing) {
  const auto colored_behind = [&](double clear_radius) {
    const Recording recording = record("r" + std::to_string(clear_radius), {5, 15}, 0.04, {{0, 0, 2}}, 5);
    params_.depth.clear_radius = clear_radius;
    colorize(recording, params_, {});
    const Cloud cloud = colored(recording);
    std::size_t count = 0;
    for (Index i = 0; i < cloud.positions.cols(); ++i) {
      if (cloud.positions(0, i) > 10 && viewCountOf(cloud, i) > 0) ++count;
    }
    return count;
  };
  EXPECT_EQ(colored_behind(0), 0U);
  EXPECT_GT(colored_behind(5.5), 1000U);
}

TEST_F(Colorize, ChunkedAgreesWithWhole) {
  const Recording recording = record("r", {5}, 0.012, kThreeCameras, 5);
  ASSERT_GE(recording.numPoints(), 200000U);
  params_.chunks.max_chunk_points = 100000000;
  colorize(recording, params_, {});
  const Cloud whole = colored(recording);
  params_.chunks.max_chunk_points = 30000;
  colorize(recording, params_, {});
  const Cloud chunked = colored(recording);
  double difference = 0;
  for (Index i = 0; i < whole.positions.cols(); ++i) {
    difference += (colorOf(whole, i) - colorOf(chunked, i)).cwiseAbs().mean();
  }
  EXPECT_LT(difference / static_cast<double>(whole.positions.cols()), 0.5);
}

TEST_F(Colorize, AnyNumberOfThreadsGivesTheSameBytes) {
  params_.colorize.method = Method::kDefault;
  params_.chunks.max_chunk_points = 2000;
  std::vector<std::string> files;
  for (const int threads : {1, 3}) {
    const Recording recording = record("r" + std::to_string(threads), {5, 6}, 0.06, kThreeCameras, 5);
    params_.colorize.num_threads = threads;
    colorize(recording, params_, {});
    const std::string path = scratch_ / ("map" + std::to_string(threads) + ".ply");
    EXPECT_EQ(saveColored(recording, params_, path, {}), recording.numPoints());
    files.push_back(bytesOf(path));
  }
  EXPECT_EQ(files[0], files[1]);
}

TEST_F(Colorize, ACancelledRunIsResumedWithTheSameResult) {
  params_.chunks.max_chunk_points = 2000;
  params_.colorize.num_threads = 1;
  const Recording straight = record("straight", {5}, 0.06, kThreeCameras, 5);
  colorize(straight, params_, {});
  const Recording stopped = record("stopped", {5}, 0.06, kThreeCameras, 5);
  int polls = 0;
  Callbacks callbacks;
  callbacks.cancelled = [&] { return ++polls > 40; };
  EXPECT_THROW(colorize(stopped, params_, callbacks), Cancelled);
  colorize(stopped, params_, {});
  EXPECT_EQ(colored(stopped).records, colored(straight).records);
}

TEST_F(Colorize, OtherParametersDoNotReuseOldColours) {
  const Recording recording = record("r", {5}, 0.06, kThreeCameras, 5);
  params_.colorize.method = Method::kClosest;
  colorize(recording, params_, {});
  const auto closest = colored(recording).records;
  params_.colorize.method = Method::kMean;
  colorize(recording, params_, {});
  EXPECT_NE(colored(recording).records, closest);
}

TEST_F(Colorize, UnseenPointsAreKeptDroppedOrFilled) {
  const Recording recording = record("r", {5, 5.1}, 0.05, {{0, 0, 2}}, 5);
  const ColorizeSummary summary = colorize(recording, params_, {});
  ASSERT_LT(summary.num_colored, summary.num_points);
  EXPECT_EQ(colored(recording).positions.cols(), static_cast<Index>(summary.num_points));
  params_.colorize.uncolored = Uncolored::kDrop;
  EXPECT_EQ(colored(recording).positions.cols(), static_cast<Index>(summary.num_colored));
  params_.colorize.uncolored = Uncolored::kFill;
  const Cloud filled = colored(recording);
  for (Index i = 0; i < filled.positions.cols(); ++i) {
    const bool well_inside = std::abs(filled.positions(1, i)) < 3 && std::abs(filled.positions(2, i) - 2) < 1.5;
    if (!well_inside) continue;
    EXPECT_GT(colorOf(filled, i)[1], 0) << "view_count " << viewCountOf(filled, i);
  }
}

TEST_F(Colorize, TilesAreFilesThatTogetherAreTheMap) {
  params_.colorize.uncolored = Uncolored::kDrop;
  const Recording recording = record("r", {3, -300}, 0.02, {{0, 0, 2}}, 3);
  colorize(recording, params_, {});
  const std::size_t num_points = saveColored(recording, params_, scratch_ / "map.ply", {});
  EXPECT_EQ(saveColoredTiles(recording, params_, scratch_ / "tiles", ".ply", {}), num_points);
  const nlohmann::json list = nlohmann::json::parse(readText(scratch_ / "tiles/tiles.json"));
  std::size_t sum = 0;
  for (const auto& tile : list["tiles"]) {
    CloudReader reader(scratch_ / "tiles" + ("/" + tile["file"].get<std::string>()));
    EXPECT_EQ(reader.numPoints(), tile["points"].get<std::size_t>());
    sum += reader.numPoints();
  }
  EXPECT_EQ(sum, num_points);
  EXPECT_EQ(list["points"].get<std::size_t>(), num_points);

  // What the next map has not, goes; what is the user's own stays.
  writeText(scratch_ / "tiles/mine.ply", "mine");
  params_.colorize.uncolored = Uncolored::kKeep;
  const std::string first = list["tiles"][0]["file"];
  saveColoredTiles(recording, params_, scratch_ / "tiles", ".las", {});
  EXPECT_FALSE(std::filesystem::exists(scratch_ / "tiles" + ("/" + first)));
  EXPECT_EQ(readText(scratch_ / "tiles/mine.ply"), "mine");
}

TEST_F(Colorize, RadianceIsSavedBesideItsColoursWithoutColouringAgain) {
  params_.colorize.method = Method::kDefault;
  const Recording recording = record("r", {5}, 0.06, kThreeCameras, 5);
  colorize(recording, params_, {});
  const Cloud display = colored(recording);
  params_.colorize.tone = Tone::kRadiance;
  const Cloud radiance = colored(recording);
  EXPECT_EQ(display.fields.size() + 3, radiance.fields.size());
  EXPECT_EQ(recordSize(display.fields) + 12, recordSize(radiance.fields));
  ASSERT_TRUE(findField(radiance.fields, "radiance_red"));
  int compared = 0;
  for (Index i = 0; i < radiance.positions.cols(); ++i) {
    if (viewCountOf(radiance, i) == 0) continue;
    float red = 0;
    std::memcpy(&red, radiance.records.data() + static_cast<std::size_t>(i + 1) * recordSize(radiance.fields) - 12, 4);
    EXPECT_NEAR(colorOf(radiance, i)[0], static_cast<double>(red), 0.51);
    EXPECT_NEAR(colorOf(display, i)[0], static_cast<double>(red), 0.1 * static_cast<double>(red));
    ++compared;
  }
  EXPECT_GT(compared, 1000);
}

TEST_F(Colorize, WhatMovedIsMarkedHidesNothingAndCanBeDropped) {
  // A van at x = 3 in front of a wall at 5: of three scans the second ends at it, as does the view of that moment.
  Recorder recorder(scratch_ / "r", "map", record_);
  const Eigen::Isometry3d identity = Eigen::Isometry3d::Identity();
  const Cloud van = wall(3, 0.05), behind = wall(5, 0.05);
  recorder.addCloud(behind, identity);
  recorder.addCloud(van, identity);
  const auto camera = recorder.setCamera("camera_0", intrinsics_);
  for (int i = 0; i < 3; ++i) {
    Eigen::Isometry3d map_from_sensor = identity;
    map_from_sensor.translation() << 0, i - 1, 2;
    recorder.addScan("lidar", i, map_from_sensor.inverse() * wall(i == 1 ? 3 : 5, 0.02).positions, map_from_sensor);
    const Eigen::Vector3d at(0, i - 1, 2);
    recorder.addView(camera, i, cameraAt(0, i - 1, 2), imageOfWall(intrinsics_, at, i == 1 ? 3 : 5, 1), "png");
  }
  const Recording recording = recorder.snapshot();
  colorize(recording, params_, {});
  const Cloud marked = colored(recording);
  ASSERT_EQ(marked.fields.back().name, "moving");
  const std::size_t step = recordSize(marked.fields);
  for (Index i = 0; i < marked.positions.cols(); ++i) {
    const Eigen::Vector3d at = marked.positions.col(i);
    if (std::abs(at.y()) > 1 || std::abs(at.z() - 2) > 1) continue;
    const bool is_van = at.x() < 4;
    EXPECT_EQ(marked.records[(static_cast<std::size_t>(i) + 1) * step - 1] >= 128, is_van) << at.transpose();
    EXPECT_EQ(viewCountOf(marked, i), is_van ? 1 : 2) << at.transpose();
  }
  params_.colorize.moving = Moving::kDrop;
  const Cloud dropped = colored(recording);  // the same colours, without colouring again
  EXPECT_LT(dropped.positions.cols(), marked.positions.cols());
  EXPECT_EQ(static_cast<Index>(saveColored(recording, params_, scratch_ / "dropped.ply", {})),
            dropped.positions.cols());
  params_.colorize.moving = Moving::kKeep;
  EXPECT_EQ(coloredFields(recording, params_).back().name, "color_stddev");
}

TEST_F(Colorize, AnImageOfClassesFollowsTheImageOfColoursThatItBelongsTo) {
  Recorder recorder(scratch_ / "r", "map", record_);
  recorder.addCloud(wall(5, 0.05), Eigen::Isometry3d::Identity());
  const auto camera = recorder.setCamera("camera_0", intrinsics_);
  const auto labels = recorder.setCamera("camera_1", intrinsics_, {ImageKind::kLabels, "label", 1, 0, ""});
  for (int i = 0; i < 5; ++i) {
    Eigen::Isometry3d pose = cameraAt(0, 0.4 * (i - 2), 2);
    const std::vector<std::uint8_t> image = imageOfWall(intrinsics_, pose.translation(), 5, 1);
    if (i == 2) pose.linear() *= Eigen::AngleAxisd(0.01, Eigen::Vector3d::UnitY()).toRotationMatrix();
    recorder.addView(camera, i, pose, image, "png");
    if (i != 2) continue;
    std::vector<std::uint8_t> classes;
    cv::imencode(".png", cv::Mat1b(intrinsics_.height, intrinsics_.width, std::uint8_t{1}), classes);
    recorder.addView(labels, i, pose, classes, "png");
  }
  const Recording recording = recorder.snapshot();
  params_.colorize.method = Method::kDefault;
  params_.alignment.pose_rotation_prior = 0.5;
  colorize(recording, params_, {});
  const auto used = usedPoses(recording, params_);
  EXPECT_EQ(used[3].matrix(), used[2].matrix());
  EXPECT_NE(used[3].matrix(), recording.views()[3].map_from_camera.matrix());
}

TEST_F(Colorize, AMapWithAppearanceHasColoursWithoutSheenBesideItsColours) {
  params_.colorize.method = Method::kDefault;  // whose gains leave nothing that depends on the view
  const Recording recording = record("r", {5}, 0.1, kThreeCameras, 5);
  colorize(recording, params_, {});
  const Cloud without = colored(recording);
  params_.colorize.appearance = Appearance::kSh1;
  EXPECT_THROW(colored(recording), std::runtime_error);  // was coloured with another parameter
  colorize(recording, params_, {});
  const Cloud with = colored(recording);
  const auto red = findField(with.fields, "diffuse_red"), share = findField(with.fields, "specular");
  ASSERT_TRUE(red && share);
  const std::size_t size = recordSize(with.fields);
  for (Index i = 0; i < with.positions.cols(); ++i) {
    EXPECT_LT((colorOf(with, i) - colorOf(without, i)).cwiseAbs().maxCoeff(), 1.5);  // a matte wall
    const std::uint8_t* record = with.records.data() + static_cast<std::size_t>(i) * size;
    EXPECT_NEAR(numberAt(record + red->offset, FieldType::kFloat32), colorOf(with, i)[0], 1.5);
    EXPECT_LT(numberAt(record + share->offset, FieldType::kUint8), 8);
  }
}

TEST_F(Colorize, ReasonsAddUpToAllPoints) {
  record_.max_range = 70;  // so views colour up to 46.7 m
  const Recording recording = record("r", {5, 15, 60}, 0.1, {{0, 0, 2}}, 5);
  const ColorizeSummary summary = colorize(recording, params_, {});
  std::size_t sum = 0;
  for (const std::size_t count : summary.by_reason) sum += count;
  EXPECT_EQ(sum, recording.numPoints());
  EXPECT_GT(summary.by_reason[static_cast<std::size_t>(Unseen::kTooFar)], 0U);
  EXPECT_NE(summary.describe().find("beyond max_view_distance"), std::string::npos);
  params_.depth.max_view_distance = std::numeric_limits<double>::infinity();
  EXPECT_EQ(colorize(recording, params_, {}).by_reason[static_cast<std::size_t>(Unseen::kTooFar)], 0U);
}

TEST_F(Colorize, ARecordingWithoutPointsOrViewsSaysSo) {
  const Recording no_views = record("no_views", {5}, 0.1, {}, 5);
  EXPECT_THROW(colorize(no_views, params_, {}), std::runtime_error);
  const Recording no_points = record("no_points", {}, 0.1, {{0, 0, 2}}, 5);
  EXPECT_THROW(colorize(no_points, params_, {}), std::runtime_error);
}

TEST_F(Colorize, InputColoursKeepTheirValuesUnderAnotherName) {
  Recorder recorder(scratch_ / "r", "map", record_);
  Cloud cloud = wall(5, 0.5);
  cloud.fields = {{"rgb", FieldType::kFloat32, 1}};
  recorder.addCloud(cloud, Eigen::Isometry3d::Identity());
  const auto fields = coloredFields(recorder.snapshot(), params_);
  EXPECT_EQ(fields[0].name, "input_rgb");
  EXPECT_EQ(fields[1].name, "rgb");
}

TEST_F(Colorize, OwnOutputAsInputIsReplacedAndTheUsersColoursStay) {
  const auto fieldsOf = [&](const std::string& name, const std::vector<Field>& fields) {
    Recorder recorder(scratch_ / name, "map", record_);
    Cloud cloud = wall(5, 0.5);
    cloud.fields = fields;
    cloud.records.resize(static_cast<std::size_t>(cloud.positions.cols()) * recordSize(fields));
    recorder.addCloud(cloud, Eigen::Isometry3d::Identity());
    std::string names;
    for (const Field& field : coloredFields(recorder.snapshot(), params_)) names += field.name + ' ';
    return names;
  };
  const Field intensity{"intensity", FieldType::kFloat32}, rgb{"rgb", FieldType::kFloat32},
      input_rgb{"input_rgb", FieldType::kFloat32}, count{"view_count", FieldType::kUint16},
      stddev{"color_stddev", FieldType::kFloat32};
  EXPECT_EQ(fieldsOf("once", {rgb, intensity}), "input_rgb intensity rgb view_count color_stddev ");
  EXPECT_EQ(fieldsOf("again", {input_rgb, intensity, rgb, count, stddev}),
            "input_rgb intensity rgb view_count color_stddev ");
  EXPECT_EQ(fieldsOf("ply", {{"red", FieldType::kUint8},
                             {"green", FieldType::kUint8},
                             {"blue", FieldType::kUint8},
                             count,
                             stddev,
                             intensity}),
            "intensity rgb view_count color_stddev ");
  EXPECT_EQ(fieldsOf("clash", {rgb, input_rgb}), "input_input_rgb input_rgb rgb view_count color_stddev ");
  EXPECT_EQ(fieldsOf("count", {count}), "input_view_count rgb view_count color_stddev ");
}

TEST_F(Colorize, AMapThatIsColouredThriceKeepsItsFieldsAndValues) {
  params_.colorize.method = Method::kMean;
  Cloud cloud = wall(5, 0.1);
  cloud.fields = {{"rgb", FieldType::kFloat32}, {"intensity", FieldType::kFloat32}};
  cloud.records.assign(static_cast<std::size_t>(cloud.positions.cols()) * 8, 7);
  std::string before;
  for (const char* name : {"1.ply", "2.ply", "3.pcd", "4.ply"}) {
    Recorder recorder(scratch_ / ("r" + std::string(name)), "map", record_);
    recorder.addCloud(cloud, Eigen::Isometry3d::Identity());
    const auto camera = recorder.setCamera("camera_0", intrinsics_);
    const Eigen::Vector3d at(0, 0, 2);
    recorder.addView(camera, 0, cameraAt(0, 0, 2), imageOfWall(intrinsics_, at, 5, 1), "png");
    const Recording recording = recorder.snapshot();
    colorize(recording, params_, {});
    saveColored(recording, params_, scratch_ / name, {});
    CloudReader reader(scratch_ / name);
    cloud = reader.read(reader.numPoints());
    const std::string now(cloud.records.begin(), cloud.records.end());
    EXPECT_TRUE(now == before || (name != std::string("2.ply") && name != std::string("4.ply")));
    if (name != std::string("3.pcd")) before = now;
  }
}

/// Kinds of damage behind a good header.
std::vector<std::vector<std::uint8_t>> damagedImages(const std::vector<std::uint8_t>& png) {
  std::vector<std::vector<std::uint8_t>> kinds(4, png);
  kinds[0].resize(png.size() / 2);
  std::fill(kinds[1].begin() + 60, kinds[1].end(), 0);
  for (std::size_t i = png.size() / 3; i < png.size() / 3 + 40; ++i) kinds[2][i] ^= 0x5A;
  kinds[3].resize(40);
  return kinds;
}

TEST_F(Colorize, AViewWithADamagedImageIsLeftOutAndNamed) {
  params_.colorize.method = Method::kDefault;
  const auto recordWith = [&](const std::string& name, const std::vector<std::uint8_t>* third) {
    Recorder recorder(scratch_ / name, "map", record_);
    recorder.addCloud(wall(5, 0.1), Eigen::Isometry3d::Identity());
    const auto camera = recorder.setCamera("camera_0", intrinsics_);
    for (int i = 0; i < 5; ++i) {
      const Eigen::Vector3d at(0, -1 + 0.5 * i, 2);
      const auto image = imageOfWall(intrinsics_, at, 5, 1 + 0.1 * i);
      if (i != 2 || third) recorder.addView(camera, 10 * i, cameraAt(0, at.y(), 2), i == 2 ? *third : image, "png");
    }
    return recorder.snapshot();
  };
  const Recording without = recordWith("without", nullptr);
  colorize(without, params_, {});
  const auto expected = colored(without).records;
  const auto whole = imageOfWall(intrinsics_, {0, 0, 2}, 5, 1.2);
  int kind = 0;
  for (const auto& image : damagedImages(whole)) {
    const Recording recording = recordWith("damaged" + std::to_string(kind++), &image);
    const std::string path = recording.directory() + '/' + recording.views()[2].image;
    std::string log;
    Callbacks callbacks;
    callbacks.log = [&](LogLevel level, const std::string& line) { log += level == LogLevel::kWarning ? line : ""; };
    const ColorizeSummary summary = colorize(recording, params_, callbacks);
    EXPECT_EQ(summary.num_damaged_views, 1U);
    EXPECT_NE(summary.describe().find("left out"), std::string::npos);
    EXPECT_NE(log.find(path), std::string::npos) << log;
    EXPECT_EQ(colored(recording).records, expected);
    if (kind > 1) continue;
    writeText(path, std::string(whole.begin(), whole.end()));  // repaired
    EXPECT_EQ(colorize(recording, params_, {}).num_damaged_views, 0U);
    EXPECT_NE(colored(recording).records, expected);
  }
}

TEST_F(Colorize, WithoutAnyWholeImageItSaysSo) {
  const Recording recording = record("r", {5}, 0.1, {{0, 0, 2}}, 5);
  writeText(recording.directory() + '/' + recording.views()[0].image, "no image");
  EXPECT_ERROR(colorize(recording, params_, {}), "000000.png");
}

TEST_F(Colorize, DamagedDerivedFilesAreMadeAgain) {
  params_.colorize.method = Method::kDefault;
  const Recording recording = record("r", {5, 6}, 0.1, kThreeCameras, 5);
  colorize(recording, params_, {});
  std::map<std::string, std::string> whole;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(recording.directory())) {
    if (entry.path().extension() == ".bin") whole[entry.path().string()] = bytesOf(entry.path().string());
  }
  ASSERT_GT(whole.size(), 6U);
  std::mt19937 random(1);
  for (const char* folder : {"damaged_images", "surfels", "alignment", "depth", "colored"}) {
    for (const auto& [path, bytes] : whole) {
      if (path.find(folder) == std::string::npos || random() % 4 == 1) continue;
      std::string damaged = bytes;
      damaged[random() % damaged.size()] ^= 0x10;
      if (random() % 3 == 0) damaged.resize(random() % damaged.size());
      writeText(path, damaged);
    }
    colorize(recording, params_, {});
    for (const auto& [path, bytes] : whole) EXPECT_EQ(bytesOf(path), bytes) << path;
  }
}

TEST_F(Colorize, PosesOfAnotherRunAreNeverWritten) {
  params_.colorize.method = Method::kDefault;
  const Recording recording = record("r", {5}, 0.1, kThreeCameras, 5);
  colorize(recording, params_, {});
  EXPECT_NO_THROW(usedPoses(recording, params_));
  params_.alignment.pose_rotation_prior = 0.7;
  EXPECT_ERROR(usedPoses(recording, params_), "colour the recording again");
  EXPECT_ERROR(exportModel(recording, params_, scratch_ / "model"), "other parameters");
  EXPECT_FALSE(std::filesystem::exists(scratch_ / "model/images.txt"));
}

TEST_F(Colorize, ColoursAreSavedFromAReadOnlyRecording) {
  ScratchDirectory disk;
  if (!disk.mountDisk("size=50m")) GTEST_SKIP() << "no right to mount";
  record("r", {5}, 0.1, kThreeCameras, 5);
  const Recording made = Recording::open(scratch_ / "r");
  colorize(made, params_, {});
  std::filesystem::copy(made.directory(), disk / "r", std::filesystem::copy_options::recursive);
  for (const auto& view : made.views()) {  // as `cp -p`
    std::filesystem::last_write_time(disk / ("r/" + view.image),
                                     std::filesystem::last_write_time(made.directory() + '/' + view.image));
  }
  ASSERT_EQ(mount(nullptr, disk.path().c_str(), nullptr, MS_REMOUNT | MS_RDONLY, nullptr), 0);
  saveColored(made, params_, scratch_ / "made.ply", {});
  saveColored(Recording::open(disk / "r"), params_, scratch_ / "copy.ply", {});
  EXPECT_EQ(bytesOf(scratch_ / "copy.ply"), bytesOf(scratch_ / "made.ply"));
}

}  // namespace
}  // namespace cloud_colorizer
