// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause
#include "cloud_colorizer/exchange/export_model.hpp"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <iterator>
#include <opencv2/imgcodecs.hpp>
#include <sstream>

#include "cloud_colorizer/camera/camera.hpp"
#include "cloud_colorizer/exchange/colmap.hpp"
#include "core/scratch.hpp"

namespace cloud_colorizer {
namespace {

Intrinsics intrinsicsOf(DistortionModel model, std::vector<double> distortion) {
  Intrinsics k;
  k.width = 64, k.height = 48;
  k.fx = 50, k.fy = 51, k.cx = 31.2, k.cy = 23.9;
  k.model = model;
  k.distortion = std::move(distortion);
  return k;
}

const std::vector<Intrinsics>& allModels() {
  static const std::vector<Intrinsics> kAll = {
      intrinsicsOf(DistortionModel::kPlumbBob, {0.1, -0.05, 0.001, 0.002, 0.01}),
      intrinsicsOf(DistortionModel::kRationalPolynomial, {0.1, -0.05, 0.001, 0.002, 0.01, 0.02, 0.03, 0.004}),
      intrinsicsOf(DistortionModel::kEquidistant, {0.01, 0.002, -0.003, 0.0004})};
  return kAll;
}

Eigen::Isometry3d poseOf(int i) {
  Eigen::Isometry3d pose(Eigen::AngleAxisd(0.3 * i, Eigen::Vector3d(1, 2, 3).normalized()));
  pose.translation() << 450000 + i, 5400000.25 - i, 120 + 0.5 * i;
  return pose;
}

/// One camera of each model, two views each, far from zero, later stamps first.
Recording record(const std::string& directory) {
  Recorder recorder(directory, "map", RecordParams{});
  int i = 0;
  for (std::size_t c = 0; c < allModels().size(); ++c) {
    const auto camera = recorder.setCamera("camera_" + std::to_string(c), allModels()[c]);
    for (int k = 0; k < 2; ++k, ++i) {
      recorder.addView(camera, 1317046450.123456789 - i, poseOf(i), {1, 2, 3}, "png");
    }
  }
  return recorder.snapshot();
}

std::string textOf(const std::string& path) {
  std::ifstream file(path);
  return {std::istreambuf_iterator<char>(file), {}};
}

TEST(ExportModel, ColmapReadsBackWhatWasRecorded) {
  ScratchDirectory scratch;
  const Recording recording = record(scratch / "recording");
  exportModel(recording, Params{}, scratch / "deep/model");
  const ColmapModel model = readColmapModel(scratch / "deep/model");
  ASSERT_EQ(model.images.size(), 6U);
  EXPECT_EQ(model.images[3].name, "camera_1/000003.png");
  for (int i = 0; i < 6; ++i) {
    const ColmapImage& image = model.images[static_cast<std::size_t>(i)];
    EXPECT_EQ(image.camera, static_cast<std::size_t>(i / 2));
    EXPECT_LT((image.map_from_camera.matrix() - poseOf(i).matrix()).cwiseAbs().maxCoeff(), 1e-8);
  }
  // The distortion may have another name (COLMAP's FULL_OPENCV for a k3), but the pixels are the same.
  for (std::size_t c = 0; c < 3; ++c) {
    const Eigen::Vector3d point(0.3, -0.2, 1);
    const auto ours = Camera(allModels()[c]).linearize(point), theirs = Camera(model.cameras[c]).linearize(point);
    ASSERT_TRUE(ours && theirs);
    EXPECT_LT((ours->pixel - theirs->pixel).norm(), 1e-9);
  }
  EXPECT_TRUE(std::filesystem::exists(scratch / "deep/model/points3D.txt"));
}

TEST(ExportModel, TrajectoriesAreTumByStamp) {
  ScratchDirectory scratch;
  exportModel(record(scratch / "recording"), Params{}, scratch / "model");
  std::istringstream lines(textOf(scratch / "model/trajectory_camera_1.txt"));
  std::string comment;
  std::getline(lines, comment);
  EXPECT_EQ(comment.front(), '#');
  for (const int i : {3, 2}) {
    double stamp = 0, x = 0, y = 0, z = 0;
    Eigen::Quaterniond q;
    lines >> stamp >> x >> y >> z >> q.x() >> q.y() >> q.z() >> q.w();
    EXPECT_NEAR(stamp, 1317046450.123456789 - i, 1e-6);
    EXPECT_LT((Eigen::Vector3d(x, y, z) - poseOf(i).translation()).norm(), 1e-8);
    EXPECT_LT(q.angularDistance(Eigen::Quaterniond(poseOf(i).linear())), 1e-8);
  }
  EXPECT_TRUE(std::filesystem::exists(scratch / "model/trajectory_camera_2.txt"));
}

TEST(ExportModel, NamesMayBeGivenAndMustBeOneAView) {
  ScratchDirectory scratch;
  const Recording recording = record(scratch / "recording");
  exportModel(recording, Params{}, scratch / "model", {{"a b.jpg", "b", "c", "d", "e", "f"}});
  EXPECT_EQ(readColmapModel(scratch / "model").images[0].name, "a b.jpg");
  EXPECT_THROW(exportModel(recording, Params{}, scratch / "model", {{"a"}}), std::invalid_argument);
}

/// What a camera sees of colours that follow the direction, [px] 64 x 48.
cv::Vec3b colorOf(const Eigen::Vector3d& ray) {
  const double x = ray.x() / ray.z(), y = ray.y() / ray.z();
  return {cv::saturate_cast<std::uint8_t>(120 + 100 * x), cv::saturate_cast<std::uint8_t>(120 + 100 * y), 60};
}

TEST(ExportModel, UndistortedImagesAreThoseOfPinholeCameras) {
  ScratchDirectory scratch;
  Recorder recorder(scratch / "recording", "map", RecordParams{});
  for (std::size_t c = 0; c < allModels().size(); ++c) {
    const auto id = recorder.setCamera("camera_" + std::to_string(c), allModels()[c]);
    const Camera camera(allModels()[c]);
    cv::Mat3b image(48, 64);
    for (int v = 0; v < 48; ++v) {
      for (int u = 0; u < 64; ++u) image(v, u) = colorOf(*camera.bearing({u, v}));
    }
    std::vector<std::uint8_t> bytes;
    cv::imencode(".png", image, bytes);
    recorder.addView(id, static_cast<double>(c), poseOf(0), bytes, "png");
  }
  recorder.addView(0, 9, poseOf(1), {1, 2, 3}, "png");  // no image
  const std::string model_folder = scratch / "model";
  exportModel(recorder.snapshot(), Params{}, model_folder, {{"a.png", "deep/b.tiff", "c", "d"}, true});
  const ColmapModel model = readColmapModel(model_folder);
  ASSERT_EQ(model.images.size(), 3U);
  EXPECT_EQ(model.images[1].name, "deep/b.png");
  EXPECT_NE(textOf(model_folder + "/cameras.txt").find("2 PINHOLE 64 48 50 51"), std::string::npos);
  for (const ColmapImage& image : model.images) {
    const Camera camera(model.cameras[image.camera]);
    const cv::Mat3b seen = cv::imread(model_folder + "/images/" + image.name);
    ASSERT_EQ(seen.size(), cv::Size(64, 48)) << image.name;
    for (int v = 6; v < 42; ++v) {
      for (int u = 6; u < 58; ++u) {
        EXPECT_LE(cv::norm(seen(v, u) - colorOf(*camera.bearing({u, v})), cv::NORM_INF), 2)
            << image.name << u << ' ' << v;
      }
    }
  }
  EXPECT_THROW(exportModel(recorder.snapshot(), Params{}, model_folder, {{"../a.png", "b", "c", "d"}, true}),
               std::runtime_error);
}

TEST(ExportModel, UnwritableFolderIsAnError) {
  ScratchDirectory scratch;
  const Recording recording = record(scratch / "recording");
  std::ofstream(scratch / "file") << "no folder";
  EXPECT_THROW(exportModel(recording, Params{}, scratch / "file"), std::runtime_error);
}

}  // namespace
}  // namespace cloud_colorizer
