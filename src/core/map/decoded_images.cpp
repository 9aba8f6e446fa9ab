// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause
#include "map/decoded_images.hpp"

#include <filesystem>
#include <utility>

#include "base/text.hpp"

namespace cloud_colorizer {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kChannels = 3;
constexpr std::uintmax_t kFreeShare = 2;  // so many times what the pixels take must be free

std::size_t numBytes(const Recording& recording, std::size_t view) {
  const Intrinsics& k = recording.cameras()[recording.views()[view].camera].intrinsics;
  return static_cast<std::size_t>(k.width) * static_cast<std::size_t>(k.height) * kChannels;
}

}  // namespace

DecodedImages::DecodedImages(const Recording& recording, std::size_t max_bytes)
    : recording_(recording),
      max_bytes_(max_bytes),
      folder_(recording.directory() + "/decoded"),
      images_(
          max_bytes, [this](std::size_t view) { return load(view); },
          [](const Decoded& decoded) { return decoded.image.total() * decoded.image.elemSize(); }) {}

DecodedImages::~DecodedImages() {
  std::error_code ignored;
  if (on_disk_) fs::remove_all(folder_, ignored);
}

std::shared_ptr<const cv::Mat> DecodedImages::get(std::size_t view) {
  const auto decoded = images_.get(view);
  return {decoded, &decoded->image};
}

void DecodedImages::prepareFolder() {
  std::uintmax_t all = 0;
  for (std::size_t view = 0; view < recording_.views().size(); ++view) all += numBytes(recording_, view);
  std::error_code error;
  fs::remove_all(folder_, error);  // of a run that was killed
  if (all <= max_bytes_ || fs::space(recording_.directory(), error).available / kFreeShare < all || error) return;
  on_disk_ = fs::create_directory(folder_, error);
}

DecodedImages::Decoded DecodedImages::load(std::size_t view) {
  std::call_once(prepared_, [this] { prepareFolder(); });
  if (!on_disk_) return {recording_.readImage(view), nullptr};
  const std::string path = folder_ + '/' + sixDigits(view);
  if (!fs::exists(path)) {
    cv::Mat image = recording_.readImage(view);
    writeFileAtomically(path, image.data, image.total() * image.elemSize());
    return {std::move(image), nullptr};
  }
  const Intrinsics& k = recording_.cameras()[recording_.views()[view].camera].intrinsics;
  auto pixels = std::make_shared<const MappedFile>(path, numBytes(recording_, view));
  // Nobody writes to an image that is handed out.
  cv::Mat image(k.height, k.width, CV_8UC3, const_cast<std::uint8_t*>(pixels->data()));
  return {std::move(image), std::move(pixels)};
}

}  // namespace cloud_colorizer
