// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause
#include "exchange/import_labels.hpp"

#include <filesystem>
#include <opencv2/imgcodecs.hpp>
#include <string>

#include "base/file_io.hpp"
#include "base/progress.hpp"
#include "base/text.hpp"
#include "camera/npy.hpp"
#include "camera/values.hpp"
#include "cloud_colorizer/base/check.hpp"
#include "recording/image_files.hpp"

namespace cloud_colorizer {
namespace {

struct LabelImage {
  cv::Size size;
  ImageKind kind = ImageKind::kLabels;
  std::vector<std::uint8_t> bytes;
};

LabelImage readLabels(const std::string& path) {
  LabelImage labels;
  labels.bytes = readFile(path);
  const cv::Mat image = isNpy(labels.bytes) ? matOfNpy(labels.bytes)
                                            : decodeFile(path, cv::IMREAD_UNCHANGED | cv::IMREAD_IGNORE_ORIENTATION);
  require(!image.empty(), path, " cannot be decoded: it is no image of a known format, or damaged");
  labels.size = image.size();
  if (isNpy(labels.bytes) && image.channels() > 1) labels.kind = ImageKind::kLogits;
  requireValues(image.type(), labels.kind, path);
  return labels;
}

}  // namespace

void importLabels(const ModelFiles& files, const ColmapModel& model, const std::vector<Photo>& photos,
                  Recorder& recorder, const Callbacks& callbacks) {
  if (files.labels.empty()) return;
  require(std::filesystem::is_directory(files.labels), "labels directory ", files.labels, " does not exist");
  Notice missing;
  ProgressMeter progress(callbacks, "import labels", photos.size());
  for (std::size_t i = 0; i < photos.size(); ++i, progress.add(1)) {
    const ColmapImage& image = model.images[i];
    const Intrinsics& camera = model.cameras[image.camera];
    require(!isPanorama(camera), "--labels of panoramas are not read; cut the panoramas into images first");
    const std::string path = findBeside(files.labels, image.name, {".png", ".npy"});
    if (path.empty()) {
      missing.add(image.name);
      continue;
    }
    const LabelImage labels = readLabels(path);
    require(hasShapeOf(labels.size, photos[i].size()), path, " is ", labels.size.width, " x ", labels.size.height,
            " px, which is not the shape of its photo of ", photos[i].size().width, " x ", photos[i].size().height);
    const std::uint32_t id = recorder.setCamera("labels_" + std::to_string(image.camera), scaledTo(camera, labels.size),
                                                {labels.kind, "label", 1, 0, files.names});
    cv::Mat1b mask = photos[i].mask();
    if (!mask.empty()) mask = fittedMask(mask, labels.size);
    recorder.addView(id, static_cast<double>(i), image.map_from_camera, labels.bytes, lowerExtension(path).erase(0, 1),
                     mask);
  }
  require(missing.count() < photos.size(), "the labels directory ", files.labels,
          " has nothing for any image, such as ", model.images[0].name, ".png or .npy");
  missing.log(callbacks, LogLevel::kWarning, "no labels in " + files.labels);
}

}  // namespace cloud_colorizer
