// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause
#include "exchange/photos.hpp"

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <set>
#include <sstream>

#include "base/file_io.hpp"
#include "base/parallel.hpp"
#include "base/progress.hpp"
#include "base/text.hpp"
#include "camera/pixels.hpp"
#include "cloud_colorizer/base/check.hpp"
#include "recording/image_files.hpp"

namespace cloud_colorizer {
namespace {

namespace fs = std::filesystem;

/// Empty where the file cannot be decoded.
cv::Mat tryRead(const std::string& path, int flags) {
  try {
    return cv::imread(path, flags);
  } catch (const cv::Exception&) {
    return {};
  }
}

cv::Size turned(cv::Size size) {
  return {size.height, size.width};
}

/// By an orientation in its EXIF data. Only files that have such data are looked at further.
bool isTurnedByExif(const std::string& path) {
  std::string head(4096, '\0');
  std::ifstream(path, std::ios::binary).read(&head[0], static_cast<std::streamsize>(head.size()));
  if (head.find("Exif") == std::string::npos) return false;
  const cv::Mat applied = tryRead(path, cv::IMREAD_REDUCED_GRAYSCALE_8);
  const cv::Mat ignored = tryRead(path, cv::IMREAD_REDUCED_GRAYSCALE_8 | cv::IMREAD_IGNORE_ORIENTATION);
  return applied.size() != ignored.size() || (!applied.empty() && cv::norm(applied, ignored, cv::NORM_INF) > 0);
}

struct Look {
  cv::Size size;
  int bits = 0;            ///< that are filled of 16 a channel; 0: it has 8
  bool is_turned = false;  ///< by its EXIF data
};

Look lookAt(const std::string& path, const Intrinsics& camera) {
  const cv::Mat grey = tryRead(path, cv::IMREAD_GRAYSCALE | cv::IMREAD_ANYDEPTH | cv::IMREAD_IGNORE_ORIENTATION);
  Look look{grey.size(), 0, false};
  if (grey.empty()) look.size = {camera.width, camera.height};
  if (grey.depth() == CV_16U) look.bits = bitsOf(tryRead(path, cv::IMREAD_ANYCOLOR | cv::IMREAD_ANYDEPTH));
  look.is_turned = isTurnedByExif(path);
  return look;
}

/// The size with which the photo is used.
cv::Size usedSize(const Look& look, const Intrinsics& camera, const std::string& name, const std::string& folder) {
  const cv::Size wanted(camera.width, camera.height);
  const bool fits = hasShapeOf(look.size, wanted), fits_turned = hasShapeOf(turned(look.size), wanted);
  require(fits || (fits_turned && look.is_turned), "image ", name, " in ", folder, " is ", look.size.width, " x ",
          look.size.height, " px, but its camera in the model has ", camera.width, " x ", camera.height,
          fits_turned ? "; it seems to be turned by a quarter: turn the images as the model has them"
                      : "; give the images that the model was made from, or a model that was scaled with them");
  return fits ? look.size : turned(look.size);
}

void setMasks(const std::string& folder, const ColmapModel& model, std::vector<Photo>& photos,
              const Callbacks& callbacks) {
  if (folder.empty()) return;
  require(fs::is_directory(folder), "masks directory ", folder, " does not exist");
  Notice missing;
  for (std::size_t i = 0; i < photos.size(); ++i) {
    const std::string path = findBeside(folder, model.images[i].name, {".png"});
    if (path.empty()) missing.add(model.images[i].name);
    photos[i].setMask(path);
  }
  require(missing.count() < photos.size(), "the masks directory ", folder, " has no mask of any image, such as ",
          model.images[0].name, ".png");
  missing.log(callbacks, LogLevel::kWarning, "no mask in " + folder + ", so all of it colours");
}

/// As many as the photo of each camera fills that fills most.
void setBits(const ColmapModel& model, const std::vector<Look>& looks, std::vector<Photo>& photos,
             const Callbacks& callbacks) {
  std::vector<int> most(model.cameras.size(), 0);
  for (std::size_t i = 0; i < photos.size(); ++i) {
    int& bits = most[model.images[i].camera];
    bits = std::max(bits, looks[i].bits);
  }
  for (std::size_t i = 0; i < photos.size(); ++i) {
    if (looks[i].bits != 0) photos[i].setBits(most[model.images[i].camera]);
  }
  for (const int bits : std::set<int>(most.begin(), most.end())) {
    if (bits == 0 || bits == 16) continue;
    Notice notice;
    for (std::size_t i = 0; i < photos.size(); ++i) {
      if (photos[i].bits() == bits) notice.add(model.images[i].name);
    }
    notice.log(callbacks, LogLevel::kInfo,
               "of 16 bits a channel, " + std::to_string(bits) + " are filled, which are taken as full scale");
  }
}

void logSizes(const ColmapModel& model, const std::vector<Look>& looks, const std::vector<Photo>& photos,
              const Callbacks& callbacks) {
  Notice scaled, turned_back, maybe_turned;
  for (std::size_t i = 0; i < photos.size(); ++i) {
    const Intrinsics& camera = model.cameras[model.images[i].camera];
    const std::string& name = model.images[i].name;
    if (photos[i].size() != cv::Size(camera.width, camera.height)) scaled.add(name);
    const bool is_applied = photos[i].size() != looks[i].size;
    if (looks[i].is_turned) (is_applied ? turned_back : maybe_turned).add(name);
  }
  scaled.log(callbacks, LogLevel::kInfo, "larger or smaller than its camera in the model: the intrinsics are scaled");
  turned_back.log(callbacks, LogLevel::kInfo,
                  "turned as its EXIF orientation says, since only so it has the shape of its camera in the model");
  maybe_turned.log(callbacks, LogLevel::kInfo,
                   "has an EXIF orientation, which is not applied, as COLMAP does not; if the colours are wrong, turn "
                   "the images as the model's program did");
}

}  // namespace

std::string findBeside(const std::string& folder, const std::string& name, const std::vector<std::string>& extensions) {
  const fs::path path = fs::path(folder) / name;
  for (const std::string& extension : extensions) {
    for (const fs::path& candidate :
         {fs::path(path.string() + extension), fs::path(path).replace_extension(extension)}) {
      if (fs::is_regular_file(candidate)) return candidate.string();
    }
  }
  return {};
}

EncodedImage Photo::encoded() const {
  if (bits_ < 16) {
    const cv::Mat image = tryRead(path_, cv::IMREAD_UNCHANGED);
    if (image.depth() == CV_16U) return encodeImage(scaledTo16Bits(image, bits_), "png");
  }
  return {readFile(path_), lowerExtension(path_).erase(0, 1)};
}

ViewPixels Photo::decoded() const {
  Intrinsics intrinsics;
  intrinsics.width = size_.width;
  intrinsics.height = size_.height;
  ViewPixels pixels = decodePixels(path_, intrinsics);
  addMask(mask(), pixels.mask);
  return pixels;
}

EncodedImage Photo::encodedFace(const cv::Mat& rgb) const {
  const std::string own = lowerExtension(path_);
  cv::Mat bgr;
  cv::cvtColor(rgb, bgr, cv::COLOR_RGB2BGR);
  return encodeImage(bgr, own == ".jpg" || own == ".jpeg" ? "jpg" : "png");
}

cv::Mat1b Photo::mask() const {
  if (mask_path_.empty()) return {};
  const cv::Mat mask = tryRead(mask_path_, cv::IMREAD_GRAYSCALE | cv::IMREAD_IGNORE_ORIENTATION);
  require(!mask.empty(), "the mask ", mask_path_, " cannot be read as an image");
  try {
    return fittedMask(mask, size_);
  } catch (const std::invalid_argument& error) {
    throw std::runtime_error(mask_path_ + ": " + error.what());
  }
}

std::vector<Photo> checkPhotos(const ModelFiles& files, const ColmapModel& model, const Callbacks& callbacks) {
  require(fs::is_directory(files.images), "images directory ", files.images, " does not exist");
  const std::size_t count = model.images.size();
  std::vector<std::string> paths(count);
  for (std::size_t i = 0; i < count; ++i) {
    paths[i] = (fs::path(files.images) / model.images[i].name).string();
    require(fs::is_regular_file(paths[i]), "image ", model.images[i].name, " of the model is not in ", files.images);
  }
  std::vector<Look> looks(count);
  ProgressMeter progress(callbacks, "check images", count);
  parallelFor(0, count, [&](std::size_t i) {
    looks[i] = lookAt(paths[i], model.cameras[model.images[i].camera]);
    progress.add(1);
  });
  std::vector<Photo> photos;
  photos.reserve(count);
  for (std::size_t i = 0; i < count; ++i) {
    const ColmapImage& image = model.images[i];
    photos.emplace_back(paths[i], usedSize(looks[i], model.cameras[image.camera], image.name, files.images));
  }
  setMasks(files.masks, model, photos, callbacks);
  if (files.quantity.kind == ImageKind::kColor) setBits(model, looks, photos, callbacks);
  logSizes(model, looks, photos, callbacks);
  return photos;
}

Intrinsics scaledTo(const Intrinsics& camera, cv::Size size) {
  if (size == cv::Size(camera.width, camera.height)) return camera;  // to the bit
  const double x = static_cast<double>(size.width) / camera.width, y = static_cast<double>(size.height) / camera.height;
  Intrinsics scaled = camera;
  scaled.width = size.width;
  scaled.height = size.height;
  scaled.fx *= x;
  scaled.fy *= y;
  scaled.cx = (camera.cx + 0.5) * x - 0.5;
  scaled.cy = (camera.cy + 0.5) * y - 0.5;
  return scaled;
}

}  // namespace cloud_colorizer
