// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause
#include "cloud_colorizer/exchange/import_model.hpp"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <limits>
#include <opencv2/imgcodecs.hpp>
#include <vector>

#include "base/file_io.hpp"
#include "base/parallel.hpp"
#include "base/progress.hpp"
#include "base/text.hpp"
#include "cloud_colorizer/base/check.hpp"
#include "cloud_colorizer/cloud/cloud_io.hpp"
#include "cloud_colorizer/exchange/colmap.hpp"

namespace cloud_colorizer {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kBlock = 1000000;  // points
constexpr double kPointsPerTile = 6000;  // of a surface that fills the cloud's extent once

struct Extent {
  Eigen::AlignedBox3d box;
  std::size_t num_points = 0;  ///< finite ones
};

Extent measureCloud(const std::string& path, const Callbacks& callbacks) {
  CloudReader reader(path);
  ProgressMeter progress(callbacks, "measure cloud", reader.numPoints());
  Extent extent;
  for (Cloud block = reader.read(kBlock); block.positions.cols() > 0; block = reader.read(kBlock)) {
    for (Eigen::Index i = 0; i < block.positions.cols(); ++i) {
      if (!block.positions.col(i).allFinite()) continue;
      extent.box.extend(block.positions.col(i));
      ++extent.num_points;
    }
    progress.add(static_cast<std::size_t>(block.positions.cols()));
  }
  require(extent.num_points > 0, path, " has no point with finite coordinates");
  return extent;
}

/// Empty where the file cannot be decoded.
cv::Size imageSize(const std::string& path) {
  try {
    return cv::imread(path, cv::IMREAD_GRAYSCALE | cv::IMREAD_IGNORE_ORIENTATION).size();
  } catch (const cv::Exception&) {
    return {};
  }
}

double chooseTileSize(const Extent& extent) {
  const double side = std::max(extent.box.sizes().maxCoeff(), 1e-6);
  const double share = std::sqrt(kPointsPerTile / static_cast<double>(extent.num_points));
  return side * std::min(1.0, share) * 1.0001;  // so that a small cloud does not straddle tiles by rounding
}

void importCloud(const std::string& path, const Extent& extent, Recorder& recorder, const Callbacks& callbacks) {
  CloudReader reader(path);
  ProgressMeter progress(callbacks, "import cloud", reader.numPoints());
  const Eigen::Vector3d center = extent.box.center();
  const Eigen::Isometry3d map_from_center(Eigen::Translation3d{center});
  for (Cloud block = reader.read(kBlock); block.positions.cols() > 0; block = reader.read(kBlock)) {
    const auto count = static_cast<std::size_t>(block.positions.cols());
    block.positions.colwise() -= center;
    recorder.addCloud(block, map_from_center);
    progress.add(count);
  }
}

/// Before anything is made of them. What cannot be decoded passes: the colouring leaves it out.
void checkImages(const std::string& folder, const ColmapModel& model, const Callbacks& callbacks) {
  for (const ColmapImage& image : model.images) {
    require(fs::is_regular_file(fs::path(folder) / image.name), "image ", image.name, " of the model is not in ",
            folder);
  }
  ProgressMeter progress(callbacks, "check images", model.images.size());
  parallelFor(0, model.images.size(), [&](std::size_t i) {
    const Intrinsics& camera = model.cameras[model.images[i].camera];
    const std::string& name = model.images[i].name;
    const cv::Size size = imageSize((fs::path(folder) / name).string());
    require(size.empty() || size == cv::Size(camera.width, camera.height), "image ", name, " in ", folder, " is ",
            size.width, " x ", size.height, " px, but its camera in the model has ", camera.width, " x ", camera.height,
            "; give the images that the model was made from, or a model that was scaled with them");
    progress.add(1);
  });
}

void importViews(const ModelFiles& files, const ColmapModel& model, Recorder& recorder, const Callbacks& callbacks) {
  ProgressMeter progress(callbacks, "import images", model.images.size());
  std::vector<std::uint32_t> cameras;
  for (std::size_t i = 0; i < model.cameras.size(); ++i) {
    cameras.push_back(recorder.setCamera("camera_" + std::to_string(i), model.cameras[i]));
  }
  for (std::size_t i = 0; i < model.images.size(); ++i) {
    const ColmapImage& image = model.images[i];
    // A model has no times; the order of the images stands for it.
    recorder.addView(cameras[image.camera], static_cast<double>(i), image.map_from_camera,
                     readFile((fs::path(files.images) / image.name).string()), lowerExtension(image.name).erase(0, 1));
    progress.add(1);
  }
}

}  // namespace

Recording importModel(const ModelFiles& files, const std::string& directory, const RecordParams& params,
                      const Callbacks& callbacks) {
  require(fs::is_directory(files.images), "images directory ", files.images, " does not exist");
  require(!fs::exists(directory + "/recording.yaml"), directory,
          " already holds a recording; colour it with `colorize`, or name another folder");
  const ColmapModel model = readColmapModel(files.model);
  require(!model.images.empty(), files.model, "/images.txt lists no images");
  checkImages(files.images, model, callbacks);
  const Extent extent = measureCloud(files.cloud, callbacks);
  RecordParams adapted = params;
  adapted.min_range = 0;
  adapted.max_range = std::numeric_limits<double>::max();
  if (params.tile_size == 0 && params.voxel_size == 0) adapted.tile_size = chooseTileSize(extent);

  Recorder recorder(directory, "map", adapted);
  importCloud(files.cloud, extent, recorder, callbacks);
  importViews(files, model, recorder, callbacks);
  return recorder.snapshot();
}

}  // namespace cloud_colorizer
