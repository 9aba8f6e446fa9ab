// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause
#include "cloud_colorizer/exchange/import_model.hpp"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <limits>
#include <map>
#include <tuple>
#include <vector>

#include "base/parallel.hpp"
#include "base/progress.hpp"
#include "camera/panorama.hpp"
#include "cloud_colorizer/base/check.hpp"
#include "cloud_colorizer/cloud/cloud_io.hpp"
#include "cloud_colorizer/exchange/colmap.hpp"
#include "exchange/import_labels.hpp"
#include "exchange/model_check.hpp"
#include "exchange/photos.hpp"

namespace cloud_colorizer {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kBlock = 1000000;  // points
constexpr std::size_t kSamples = 2000;   // points that tell whether the poses can be right
constexpr double kPointsPerTile = 6000;  // of a surface that fills the cloud's extent once

struct Extent {
  Eigen::AlignedBox3d box;
  std::size_t num_points = 0;            ///< finite ones
  std::vector<Eigen::Vector3d> samples;  ///< some of them, spread over the file
};

Extent measureCloud(const std::string& path, const Callbacks& callbacks) {
  CloudReader reader(path);
  ProgressMeter progress(callbacks, "measure cloud", reader.numPoints());
  Extent extent;
  const std::size_t stride = std::max<std::size_t>(1, reader.numPoints() / kSamples);
  for (Cloud block = reader.read(kBlock); block.positions.cols() > 0; block = reader.read(kBlock)) {
    for (Eigen::Index i = 0; i < block.positions.cols(); ++i) {
      if (!block.positions.col(i).allFinite()) continue;
      extent.box.extend(block.positions.col(i));
      if (extent.num_points % stride == 0) extent.samples.emplace_back(block.positions.col(i));
      ++extent.num_points;
    }
    progress.add(static_cast<std::size_t>(block.positions.cols()));
  }
  require(extent.num_points > 0, path, " has no point with finite coordinates");
  return extent;
}

double chooseTileSize(const Extent& extent) {
  const double side = std::max(extent.box.sizes().maxCoeff(), 1e-6);
  const double share = std::sqrt(kPointsPerTile / static_cast<double>(extent.num_points));
  return side * std::min(1.0, share) * 1.0001;  // so that a small cloud does not straddle tiles by rounding
}

void importCloud(const std::string& path, const Extent& extent, Recorder& recorder, const Callbacks& callbacks) {
  CloudReader reader(path);
  if (!reader.crs().empty()) recorder.setCrs(reader.crs());
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

using CameraIds = std::vector<std::uint32_t>;  // one, or of each face of a panorama

/// Of the cameras of the model, for each size that their photos have. Returns those of each image.
std::vector<CameraIds> setCameras(const ColmapModel& model, const Quantity& quantity, const std::vector<Photo>& photos,
                                  Recorder& recorder) {
  using Key = std::tuple<std::size_t, int, int>;  // camera, width, height
  std::map<Key, CameraIds> ids;
  std::vector<CameraIds> cameras;
  for (std::size_t i = 0; i < photos.size(); ++i) {
    const std::size_t camera = model.images[i].camera;
    const cv::Size size = photos[i].size();
    CameraIds& own = ids[{camera, size.width, size.height}];
    const std::string name = "camera_" + std::to_string(camera);
    if (own.empty() && isPanorama(model.cameras[camera])) {
      require(quantity.kind == ImageKind::kColor, "panoramas can only show colours");
      for (const PanoramaFace& face : panoramaFaces(size.width)) {
        own.push_back(recorder.setCamera(name + '_' + face.name, face.intrinsics));
      }
    } else if (own.empty()) {
      own.push_back(recorder.setCamera(name, scaledTo(model.cameras[camera], size), quantity));
    }
    cameras.push_back(own);
  }
  return cameras;
}

/// Its faces become views at one place; black and masked ones where it is damaged.
void importPanorama(const Photo& photo, double stamp, const Eigen::Isometry3d& map_from_camera, const CameraIds& ids,
                    Recorder& recorder, const Callbacks& callbacks) {
  ViewPixels pixels{cv::Mat3b(photo.size(), cv::Vec3b(0, 0, 0)), cv::Mat1b(photo.size(), std::uint8_t{0})};
  try {
    pixels = photo.decoded();
  } catch (const std::runtime_error& error) {
    if (callbacks.log) callbacks.log(LogLevel::kWarning, std::string("a view is left out: ") + error.what());
  }
  const std::vector<PanoramaFace> faces = panoramaFaces(photo.size().width);
  std::vector<EncodedImage> encoded(faces.size());
  std::vector<cv::Mat> masks(faces.size());
  parallelFor(0, faces.size(), [&](std::size_t i) {
    encoded[i] = photo.encodedFace(cutFace(pixels.image, faces[i]));
    masks[i] = cutMask(pixels.mask, faces[i]);
  });
  for (std::size_t i = 0; i < faces.size(); ++i) {
    Eigen::Isometry3d pose = map_from_camera;
    pose.linear() *= faces[i].panorama_from_face;
    recorder.addView(ids[i], stamp, pose, encoded[i].bytes, encoded[i].extension, masks[i]);
  }
}

void importViews(const ColmapModel& model, const Quantity& quantity, const std::vector<Photo>& photos,
                 Recorder& recorder, const Callbacks& callbacks) {
  ProgressMeter progress(callbacks, "import images", photos.size());
  const std::vector<CameraIds> cameras = setCameras(model, quantity, photos, recorder);
  for (std::size_t i = 0; i < photos.size(); ++i) {
    const Eigen::Isometry3d& pose = model.images[i].map_from_camera;
    const auto stamp = static_cast<double>(i);  // a model has no times; the order of the images stands for it
    if (isPanorama(model.cameras[model.images[i].camera])) {
      importPanorama(photos[i], stamp, pose, cameras[i], recorder, callbacks);
    } else {
      const EncodedImage encoded = photos[i].encoded();
      recorder.addView(cameras[i][0], stamp, pose, encoded.bytes, encoded.extension, photos[i].mask());
    }
    progress.add(1);
  }
}

}  // namespace

std::vector<std::string> namesOfViews(const ColmapModel& model) {
  std::vector<std::string> names;
  for (const ColmapImage& image : model.images) {
    const Intrinsics& camera = model.cameras[image.camera];
    if (!isPanorama(camera)) {
      names.push_back(image.name);
      continue;
    }
    const fs::path path = image.name;
    for (const PanoramaFace& face : panoramaFaces(camera.width)) {
      names.push_back((path.parent_path() / (path.stem().string() + '_' + face.name + ".png")).string());
    }
  }
  return names;
}

Recording importModel(const ModelFiles& files, const std::string& directory, const RecordParams& params,
                      const Callbacks& callbacks) {
  require(!fs::exists(directory + "/recording.yaml"), directory,
          " already holds a recording; colour it with `colorize`, or name another folder");
  const ColmapModel model = readColmapModel(files.model);
  require(!model.images.empty(), "the model in ", model.directory, " has no images");
  if (model.directory != files.model && callbacks.log) callbacks.log(LogLevel::kInfo, "model: " + model.directory);
  const std::vector<Photo> photos = checkPhotos(files, model, callbacks);
  const Extent extent = measureCloud(files.cloud, callbacks);
  if (callbacks.log) {
    for (const std::string& doubt : doubtsAbout(model, extent.samples)) callbacks.log(LogLevel::kWarning, doubt);
  }
  RecordParams adapted = params;
  adapted.min_range = 0;
  adapted.max_range = std::numeric_limits<double>::infinity();
  if (params.tile_size == 0 && params.voxel_size == 0) adapted.tile_size = chooseTileSize(extent);

  Recorder recorder(directory, "map", adapted);
  importCloud(files.cloud, extent, recorder, callbacks);
  importViews(model, files.quantity, photos, recorder, callbacks);
  importLabels(files, model, photos, recorder, callbacks);
  return recorder.snapshot();
}

}  // namespace cloud_colorizer
