// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <iterator>
#include <opencv2/imgcodecs.hpp>

#include "camera/npy.hpp"
#include "cloud_colorizer/map/colorize.hpp"
#include "cloud_colorizer/recording/recorder.hpp"
#include "core/scratch.hpp"

namespace cloud_colorizer {
namespace {

using Eigen::Index;
using Bytes = std::vector<std::uint8_t>;

const Quantity kTemperature{ImageKind::kRadiometric, "temperature", 0.01, -273.15, ""};
const Quantity kLabel{ImageKind::kLabels, "label", 1, 0, ""};

/// A wall at x = 5 m, seen along +x from the origin of y and z.
class Quantities : public ::testing::Test {
 protected:
  Quantities() {
    intrinsics_.width = 160, intrinsics_.height = 120;
    intrinsics_.fx = intrinsics_.fy = 100;
    intrinsics_.cx = 79.5, intrinsics_.cy = 59.5;
    record_.voxel_size = 0, record_.min_range = 0, record_.max_range = 1e6, record_.tile_size = 1;
    params_.colorize.method = Method::kPaper;
    Cloud wall;
    wall.positions.resize(3, 60 * 60);
    for (Index i = 0; i < wall.positions.cols(); ++i) {
      wall.positions.col(i) << 5, -1.5 + 0.05 * static_cast<double>(i % 60), -1.5 + 0.05 * static_cast<double>(i / 60);
    }
    recorder_.emplace(scratch_ / "r", "map", record_);
    recorder_->addCloud(wall, Eigen::Isometry3d::Identity());
  }

  static Bytes encoded(const cv::Mat& image) {
    Bytes bytes;
    cv::imencode(".png", image, bytes);
    return bytes;
  }

  void addView(const std::string& camera, const Quantity& quantity, const Bytes& bytes, const char* extension = "png") {
    Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
    pose.linear() << 0, 0, 1, -1, 0, 0, 0, -1, 0;
    recorder_->addView(recorder_->setCamera(camera, intrinsics_, quantity), 1, pose, bytes, extension);
  }

  /// 20 to 30 degrees from left to right: + y is left.
  Bytes thermalImage() const {
    cv::Mat1w image(intrinsics_.height, intrinsics_.width);
    for (int u = 0; u < image.cols; ++u)
      image.col(u) = cv::saturate_cast<std::uint16_t>(100 * (273.15 + 20 + 10.0 * u / image.cols));
    return encoded(image);
  }
  double temperatureAt(double y) const {
    return 20 + 10 * (intrinsics_.cx - intrinsics_.fx * y / 5) / intrinsics_.width;
  }
  Bytes labelImage() const {
    cv::Mat1b image(intrinsics_.height, intrinsics_.width, std::uint8_t{3});
    image.colRange(image.cols / 2, image.cols) = 200;
    return encoded(image);
  }

  Cloud colored() {
    const Recording recording = recorder_->snapshot();
    summary_ = colorize(recording, params_, {});
    Cloud all;
    forEachColoredTile(recording, params_, false, [&](const Cloud& tile) {
      const Index before = all.positions.cols();
      all.fields = tile.fields;
      all.positions.conservativeResize(3, before + tile.positions.cols());
      all.positions.rightCols(tile.positions.cols()) = tile.positions;
      all.records.insert(all.records.end(), tile.records.begin(), tile.records.end());
    });
    return all;
  }

  static double numberOf(const Cloud& cloud, const std::string& name, Index i) {
    const auto field = findField(cloud.fields, name);
    if (!field) throw std::runtime_error("no field " + name);
    return numberAt(cloud.records.data() + static_cast<std::size_t>(i) * recordSize(cloud.fields) + field->offset,
                    field->field.type);
  }

  ScratchDirectory scratch_;
  Intrinsics intrinsics_;
  RecordParams record_;
  Params params_;
  ColorizeSummary summary_;
  std::optional<Recorder> recorder_;
};

TEST_F(Quantities, ColoursTemperaturesAndClassesInOneMap) {
  addView("camera_0", {}, encoded(cv::Mat3b(120, 160, cv::Vec3b(30, 20, 10))));
  addView("camera_1", kTemperature, thermalImage());
  addView("camera_2", kLabel, labelImage());
  const Cloud cloud = colored();
  EXPECT_EQ(summary_.num_colored, summary_.num_points);
  for (Index i = 0; i < cloud.positions.cols(); ++i) {
    const double y = cloud.positions(1, i);
    EXPECT_NEAR(numberOf(cloud, "temperature", i), temperatureAt(y), 0.1);
    EXPECT_EQ(numberOf(cloud, "temperature_views", i), 1);
    if (std::abs(y) > 0.05) {
      EXPECT_EQ(numberOf(cloud, "label", i), y > 0 ? 3 : 200);  // never a number between
    }
    EXPECT_EQ(numberOf(cloud, "label_confidence", i), 1);
    EXPECT_EQ(numberOf(cloud, "view_count", i), 1);
  }
}

TEST_F(Quantities, AMapNeedsNoColours) {
  addView("camera_0", kTemperature, thermalImage());
  const Cloud cloud = colored();  // method default would have nothing to align
  EXPECT_EQ(summary_.num_colored, summary_.num_points);
  EXPECT_EQ(numberOf(cloud, "view_count", 5), 1);
  params_.colorize.method = Method::kDefault;
  EXPECT_NEAR(numberOf(colored(), "temperature", 5), temperatureAt(cloud.positions(1, 5)), 0.1);
}

TEST_F(Quantities, ScoresOfManyClasses) {
  cv::Mat scores(120, 160, CV_32FC(19), cv::Scalar::all(0));
  for (int v = 0; v < scores.rows; ++v) {
    for (int u = 0; u < scores.cols; ++u) scores.ptr<float>(v)[u * 19 + (u < 80 ? 4 : 17)] = 6;
  }
  addView("camera_0", {ImageKind::kLogits, "class", 1, 0, ""}, npyOf(scores), "npy");
  const Cloud cloud = colored();
  for (Index i = 0; i < cloud.positions.cols(); ++i) {
    const double y = cloud.positions(1, i);
    if (std::abs(y) < 0.1) continue;
    EXPECT_EQ(numberOf(cloud, "class", i), y > 0 ? 4 : 17);
    EXPECT_NEAR(numberOf(cloud, "class_confidence", i), std::exp(6) / (std::exp(6) + 18), 0.02);
  }
}

TEST_F(Quantities, AreKeptInTheRecordingWithTheNamesOfTheClasses) {
  Quantity named = kLabel;
  named.names = scratch_ / "classes.yaml";
  std::ofstream(named.names) << "3: road";
  addView("camera_0", named, labelImage());
  addView("camera_1", kTemperature, thermalImage());
  recorder_.reset();
  std::filesystem::remove(named.names);
  const Recording recording = Recording::open(scratch_ / "r");
  ASSERT_EQ(recording.quantities().size(), 2U);
  EXPECT_EQ(recording.quantityOf(1).scale, 0.01);
  EXPECT_FALSE(recording.hasColors());
  colorize(recording, params_, {});
  saveColored(recording, params_, scratch_ / "map.ply", {});
  std::ifstream names(scratch_ / "map.label.yaml");
  EXPECT_EQ(std::string(std::istreambuf_iterator<char>(names), {}), "3: road");
}

TEST_F(Quantities, AnImageOfAnotherKindIsLeftOutByName) {
  addView("camera_0", kLabel, encoded(cv::Mat3b(120, 160, cv::Vec3b(30, 20, 10))));
  std::string error;
  try {
    colored();
  } catch (const std::runtime_error& refused) {
    error = refused.what();
  }
  EXPECT_NE(error.find("no palette"), std::string::npos) << error;
}

}  // namespace
}  // namespace cloud_colorizer
