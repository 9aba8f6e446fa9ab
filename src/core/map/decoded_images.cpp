// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause
#include "map/decoded_images.hpp"

#include <filesystem>
#include <utility>

#include "base/text.hpp"

namespace cloud_colorizer {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kChannels = 3, kChannelsWithMask = 4;
constexpr std::uintmax_t kFreeShare = 2;  // so many times what the pixels take must be free

std::size_t numPixels(const Recording& recording, std::size_t view) {
  const Intrinsics& k = recording.cameras()[recording.views()[view].camera].intrinsics;
  return static_cast<std::size_t>(k.width) * static_cast<std::size_t>(k.height);
}

/// The mask behind the image.
void writePixels(const ViewPixels& pixels, const std::string& path) {
  AtomicFile file(path);
  for (const cv::Mat* mat : {&pixels.image, &pixels.mask}) file.append(mat->data, mat->total() * mat->elemSize());
  file.commit(false);
}

}  // namespace

DecodedImages::DecodedImages(const Recording& recording, std::size_t max_bytes, const std::string& name, bool alone)
    : recording_(recording),
      max_bytes_(max_bytes),
      folder_(folderOf(recording) + '/' + name),
      alone_(alone),
      images_(
          max_bytes, [this](std::size_t view) { return load(view); },
          [](const Decoded& decoded) {
            const ViewPixels& pixels = decoded.pixels;
            return pixels.image.total() * pixels.image.elemSize() + pixels.mask.total();
          }) {}

DecodedImages::~DecodedImages() {
  std::error_code ignored;
  if (on_disk_ && alone_) fs::remove_all(folderOf(recording_), ignored);
}

std::shared_ptr<const ViewPixels> DecodedImages::get(std::size_t view) {
  const auto decoded = images_.get(view);
  return {decoded, &decoded->pixels};
}

void DecodedImages::prepareFolder() {
  std::uintmax_t all = 0;
  for (std::size_t view = 0; view < recording_.views().size(); ++view) all += kChannels * numPixels(recording_, view);
  std::error_code error;
  if (alone_) fs::remove_all(folderOf(recording_), error);  // of a run that was killed
  if (all <= max_bytes_ || fs::space(recording_.directory(), error).available / kFreeShare < all || error) return;
  fs::create_directories(folder_, error);
  on_disk_ = !error;
}

DecodedImages::Decoded DecodedImages::load(std::size_t view) {
  std::call_once(prepared_, [this] { prepareFolder(); });
  // The files are of three channels of 8 bits.
  const bool is_color = recording_.quantityOf(view).kind == ImageKind::kColor;
  if (!on_disk_ || !is_color) return {recording_.readPixels(view), nullptr};
  const std::string path = folder_ + '/' + sixDigits(view);
  if (!fs::exists(path)) {
    ViewPixels pixels = recording_.readPixels(view);
    writePixels(pixels, path);
    return {std::move(pixels), nullptr};
  }
  const Intrinsics& k = recording_.cameras()[recording_.views()[view].camera].intrinsics;
  const std::size_t num_pixels = numPixels(recording_, view);
  const bool has_mask = fs::file_size(path) == kChannelsWithMask * num_pixels;
  auto file = std::make_shared<const MappedFile>(path, (has_mask ? kChannelsWithMask : kChannels) * num_pixels);
  auto* bytes = const_cast<std::uint8_t*>(file->data());  // nobody writes to what is handed out
  ViewPixels pixels{cv::Mat(k.height, k.width, CV_8UC3, bytes), {}};
  if (has_mask) pixels.mask = cv::Mat(k.height, k.width, CV_8UC1, bytes + kChannels * num_pixels);
  return {std::move(pixels), std::move(file)};
}

}  // namespace cloud_colorizer
