// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause
#include "cloud_colorizer/exchange/export_model.hpp"

#include <algorithm>
#include <filesystem>
#include <opencv2/imgproc.hpp>

#include "base/file_io.hpp"
#include "base/progress.hpp"
#include "base/text.hpp"
#include "camera/pixels.hpp"
#include "camera/undistort.hpp"
#include "cloud_colorizer/base/check.hpp"
#include "cloud_colorizer/exchange/colmap.hpp"
#include "cloud_colorizer/map/colorize.hpp"
#include "exchange/colmap_entries.hpp"
#include "exchange/colored_points.hpp"

namespace cloud_colorizer {
namespace {

namespace fs = std::filesystem;

constexpr int kStampDecimals = 9;

std::string tumLine(double stamp, const Eigen::Isometry3d& pose) {
  const Eigen::Vector3d t = pose.translation();
  const Eigen::Quaterniond q(pose.linear());
  std::string line = formatFixed(stamp, kStampDecimals);
  for (const double value : {t.x(), t.y(), t.z(), q.x(), q.y(), q.z(), q.w()}) line += ' ' + formatDouble(value);
  return line + '\n';
}

/// The views of one camera by ascending stamp.
std::string trajectory(const std::vector<View>& views, const std::vector<Eigen::Isometry3d>& poses,
                       std::size_t camera) {
  std::vector<std::size_t> own;
  for (std::size_t v = 0; v < views.size(); ++v) {
    if (views[v].camera == camera) own.push_back(v);
  }
  std::stable_sort(own.begin(), own.end(), [&](auto a, auto b) { return views[a].stamp < views[b].stamp; });
  std::string text = "# stamp tx ty tz qx qy qz qw: map_from_camera\n";
  for (const std::size_t v : own) text += tumLine(views[v].stamp, poses[v]);
  return text;
}

/// "images/camera_0/000000.jpg" without its first folder.
std::string imageName(const std::string& file) {
  return file.substr(file.find('/') + 1);
}

/// The name of the image with the extension of the format that it is written in; below the folder it is written to.
std::string undistortedName(const std::string& name, const std::string& extension) {
  const fs::path path = fs::path(name).lexically_normal();
  require(path.is_relative() && *path.begin() != "..", "the image ", name, " lies outside of the folder of images");
  if (lowerExtension(name) == extension || (extension == ".jpg" && lowerExtension(name) == ".jpeg")) return name;
  return fs::path(path).replace_extension(extension).string();
}

/// Writes the images without distortion, and gives those that could be written their names; the others get none.
std::vector<std::string> writeUndistorted(const Recording& recording, const std::string& directory,
                                          const std::vector<std::string>& names, const Callbacks& callbacks) {
  const std::vector<View>& views = recording.views();
  std::vector<cv::Mat2f> maps;
  for (const RecordedCamera& camera : recording.cameras()) maps.push_back(undistortionMap(camera.intrinsics));
  std::vector<std::string> written(views.size());
  ProgressMeter progress(callbacks, "undistort", views.size());
  for (std::size_t v = 0; v < views.size(); ++v, progress.add(1)) {
    if (names[v].empty()) continue;
    cv::Mat image;
    try {
      image = recording.readPixels(v).image;
    } catch (const std::runtime_error& error) {
      if (callbacks.log) callbacks.log(LogLevel::kWarning, std::string(error.what()) + "; it is left out of the model");
      continue;
    }
    cv::Mat undistorted;
    cv::remap(image, undistorted, maps[views[v].camera], cv::noArray(), cv::INTER_CUBIC, cv::BORDER_CONSTANT);
    cv::cvtColor(undistorted, undistorted, cv::COLOR_RGB2BGR);
    const std::string recorded = lowerExtension(views[v].image);
    const EncodedImage encoded = encodeImage(undistorted, recorded == ".jpg" || recorded == ".jpeg" ? "jpg" : "png");
    written[v] = undistortedName(names[v], '.' + encoded.extension);
    const fs::path file = fs::path(directory) / "images" / written[v];
    fs::create_directories(file.parent_path());
    writeFileAtomically(file.string(), encoded.bytes.data(), encoded.bytes.size());
  }
  return written;
}

}  // namespace

void exportModel(const Recording& recording, const Params& params, const std::string& directory,
                 const ExportedImages& images, const Callbacks& callbacks) {
  const std::vector<View>& views = recording.views();
  std::vector<std::string> names = images.names;
  require<std::invalid_argument>(names.empty() || names.size() == views.size(), names.size(), " names for ",
                                 views.size(), " views");
  if (names.empty()) {
    for (const View& view : views) names.push_back(imageName(view.image));
  }
  require(recording.hasColors() || !images.undistort, "there are no images of colours to undistort");
  for (std::size_t v = 0; v < views.size(); ++v) {
    if (recording.hasColors() && recording.quantityOf(v).kind != ImageKind::kColor) names[v].clear();
  }
  if (images.undistort) names = writeUndistorted(recording, directory, names, callbacks);
  std::vector<Eigen::Isometry3d> poses = usedPoses(recording, params);
  for (Eigen::Isometry3d& pose : poses) pose.pretranslate(recording.origin());
  ColmapModel model;
  for (const RecordedCamera& camera : recording.cameras()) {
    model.cameras.push_back(images.undistort ? pinholeOf(camera.intrinsics) : camera.intrinsics);
  }
  for (std::size_t v = 0; v < views.size(); ++v) {
    if (!names[v].empty()) model.images.push_back({views[v].camera, poses[v], names[v]});
  }
  writeColmapModel(directory, model);
  for (std::size_t c = 0; c < recording.cameras().size(); ++c) {
    const std::string text = trajectory(views, poses, c);
    writeFileAtomically(directory + "/trajectory_" + recording.cameras()[c].name + ".txt", text.data(), text.size());
  }
}

void exportPoints(const Recording& recording, const Params& params, const std::string& directory,
                  std::size_t max_points) {
  AtomicFile file(directory + "/points3D.txt");
  const auto append = [&](const std::string& text) { file.append(text.data(), text.size()); };
  append(kPointsHeader);
  std::size_t id = 0;
  forSomeColoredPoints(recording, params, max_points, false, [&](const Eigen::Vector3d& at, std::uint32_t rgb) {
    std::string line = std::to_string(++id);
    for (int axis = 0; axis < 3; ++axis) line += ' ' + formatDouble(at[axis]);
    for (const unsigned shift : {16U, 8U, 0U}) line += ' ' + std::to_string(rgb >> shift & 0xFFU);
    append(line + " 0\n");
  });
  file.commit(false);
}

}  // namespace cloud_colorizer
