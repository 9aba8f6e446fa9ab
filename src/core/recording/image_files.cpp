// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause
#include "recording/image_files.hpp"

#include <algorithm>
#include <array>
#include <cstdint>
#include <filesystem>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <vector>

#include "base/file_io.hpp"
#include "camera/npy.hpp"
#include "camera/pixels.hpp"
#include "camera/values.hpp"
#include "cloud_colorizer/base/check.hpp"

namespace cloud_colorizer {

namespace {

using Bytes = std::vector<std::uint8_t>;

/// libjpeg paints what is missing in grey and says nothing: a whole file has its end marker behind its scan.
bool isTornJpeg(const Bytes& bytes) {
  constexpr std::array<std::uint8_t, 2> kStart{0xFF, 0xD8}, kScan{0xFF, 0xDA}, kEnd{0xFF, 0xD9};
  if (bytes.size() < 2 || !std::equal(kStart.begin(), kStart.end(), bytes.begin())) return false;
  const auto scan = std::find_end(bytes.begin(), bytes.end(), kScan.begin(), kScan.end());
  return std::search(scan, bytes.end(), kEnd.begin(), kEnd.end()) == bytes.end();
}

/// Empty when they are no whole image.
cv::Mat decode(const Bytes& bytes, int flags) {
  if (bytes.empty() || isTornJpeg(bytes)) return {};
  try {
    return cv::imdecode(bytes, flags);
  } catch (const cv::Exception&) {  // such as a size beyond all bounds; it does not know the path
    return {};
  }
}

/// A file's bytes, and what is said of it in errors.
struct ImageFile {
  std::string path;
  Bytes bytes;

  cv::Mat decodeAs(int flags, const Intrinsics& intrinsics) const {
    cv::Mat image = decode(bytes, flags | cv::IMREAD_IGNORE_ORIENTATION);
    require(!image.empty(), "image ", path, " cannot be decoded: it is no image of a known format, or damaged");
    if (image.cols != intrinsics.width && image.cols == intrinsics.height) image = decode(bytes, flags);
    requireSize(image, intrinsics);
    return image;
  }

  /// As they are in the file.
  cv::Mat decodeNumbers(const Intrinsics& intrinsics) const {
    if (!isNpy(bytes)) return decodeAs(cv::IMREAD_UNCHANGED, intrinsics);
    try {
      cv::Mat image = matOfNpy(bytes);
      requireSize(image, intrinsics);
      return image;
    } catch (const std::runtime_error& error) {
      throw std::runtime_error(path + ": " + error.what());
    }
  }

  void requireSize(const cv::Mat& image, const Intrinsics& intrinsics) const {
    require(image.cols == intrinsics.width && image.rows == intrinsics.height, "image ", path, " is ", image.cols,
            " x ", image.rows, ", but its camera in cameras.yaml has ", intrinsics.width, " x ", intrinsics.height);
  }

  bool mayHaveAlpha() const {
    constexpr std::array<std::uint8_t, 4> kPng{0x89, 'P', 'N', 'G'};
    constexpr std::size_t kColorType = 25, kGrey = 0, kRgb = 2;
    if (bytes.size() <= kColorType) return false;
    if (bytes[0] == 0xFF && bytes[1] == 0xD8) return false;                   // JPEG
    if (bytes[0] == 'P' && bytes[1] >= '1' && bytes[1] <= '6') return false;  // of the Netpbm formats
    if (!std::equal(kPng.begin(), kPng.end(), bytes.begin())) return true;
    return bytes[kColorType] != kGrey && bytes[kColorType] != kRgb;
  }
};

}  // namespace

cv::Mat decodeFile(const std::string& path, int flags) {
  return decode(readFile(path), flags);
}

ViewPixels decodePixels(const std::string& path, const Intrinsics& intrinsics, ImageKind kind) {
  const ImageFile file{path, readFile(path)};
  if (kind != ImageKind::kColor) {
    const cv::Mat numbers = file.decodeNumbers(intrinsics);
    requireValues(numbers.type(), kind, "image " + path);
    return {shownValues(numbers, kind), {}};
  }
  ViewPixels pixels;
  if (file.mayHaveAlpha()) {
    const cv::Mat all = file.decodeAs(cv::IMREAD_UNCHANGED, intrinsics);
    pixels.mask = opaquePixels(all);
    if (all.type() == CV_8UC4) cv::cvtColor(all, pixels.image, cv::COLOR_BGRA2RGB);
  }
  if (pixels.image.empty()) {
    pixels.image = file.decodeAs(cv::IMREAD_COLOR, intrinsics);
    cv::cvtColor(pixels.image, pixels.image, cv::COLOR_BGR2RGB);
  }
  return pixels;
}

cv::Mat decodeMask(const std::string& path, const Intrinsics& intrinsics) {
  return ImageFile{path, readFile(path)}.decodeAs(cv::IMREAD_GRAYSCALE, intrinsics);
}

void writeMask(const std::string& path, const cv::Mat1b& mask, const Intrinsics& intrinsics, const std::string& owner) {
  require<std::invalid_argument>(mask.cols == intrinsics.width && mask.rows == intrinsics.height, "the mask of ", owner,
                                 " is ", mask.cols, " x ", mask.rows, ", but its images are ", intrinsics.width, " x ",
                                 intrinsics.height);
  Bytes png;
  cv::imencode(".png", mask, png);
  writeFileAtomically(path, png.data(), png.size());
}

std::string maskFileOf(const std::string& image) {
  return std::filesystem::path(image).replace_extension(".mask.png").string();
}

void addMask(const cv::Mat& mask, cv::Mat& to) {
  if (mask.empty()) return;
  if (to.empty()) {
    to = mask;
  } else {
    to.setTo(0, mask == 0);
  }
}

}  // namespace cloud_colorizer
