// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause
#include "recording/camera_list.hpp"

#include <algorithm>
#include <filesystem>
#include <utility>

#include "base/file_io.hpp"
#include "cloud_colorizer/base/check.hpp"
#include "recording/image_files.hpp"
#include "recording/recording_files.hpp"

namespace cloud_colorizer {
namespace {

Intrinsics withoutTrailingZeros(Intrinsics intrinsics) {
  auto& distortion = intrinsics.distortion;
  while (!distortion.empty() && distortion.back() == 0) distortion.pop_back();
  return intrinsics;
}

bool sameIntrinsics(const Intrinsics& a, const Intrinsics& b) {
  return a.width == b.width && a.height == b.height && a.fx == b.fx && a.fy == b.fy && a.cx == b.cx && a.cy == b.cy &&
         a.model == b.model && withoutTrailingZeros(a).distortion == withoutTrailingZeros(b).distortion;
}

}  // namespace

CameraList::CameraList(const std::string& directory, std::vector<RecordedCamera> cameras)
    : directory_(directory), cameras_(std::move(cameras)) {}

/// In the file first, so that memory never knows more.
void CameraList::write(std::vector<RecordedCamera> cameras) {
  writeCameras(directory_, cameras);
  cameras_ = std::move(cameras);
}

/// The file that tells what the labels mean, kept in the recording.
std::string CameraList::copiedNames(const Quantity& quantity) const {
  if (quantity.names.empty()) return {};
  const std::vector<std::uint8_t> bytes = readFile(quantity.names);
  makeFolder(directory_, "names");
  std::string copy = "names/" + quantity.name + std::filesystem::path(quantity.names).extension().string();
  writeFileAtomically(directory_ + '/' + copy, bytes.data(), bytes.size());
  return copy;
}

std::uint32_t CameraList::find(const std::string& name, const Intrinsics& intrinsics, const Quantity& quantity) {
  quantity.check();
  require<std::invalid_argument>(isFileName(name), "camera name \"", name,
                                 "\" must be made of letters, digits, _, - and .");
  const Camera checked(intrinsics);
  std::string candidate = name;
  for (int variant = 2;; ++variant) {
    const auto found =
        std::find_if(cameras_.begin(), cameras_.end(), [&](const RecordedCamera& c) { return c.name == candidate; });
    if (found == cameras_.end()) break;
    if (sameIntrinsics(found->intrinsics, intrinsics) && isSame(found->quantity, quantity)) {
      return static_cast<std::uint32_t>(found - cameras_.begin());
    }
    candidate = name + '_' + std::to_string(variant);
  }
  makeFolder(directory_, "images");
  makeFolder(directory_, "images/" + candidate);
  auto extended = cameras_;
  extended.push_back({candidate, intrinsics, "", quantity});
  extended.back().quantity.names = copiedNames(quantity);
  write(std::move(extended));
  return static_cast<std::uint32_t>(cameras_.size() - 1);
}

void CameraList::setMask(std::uint32_t camera, const cv::Mat1b& mask) {
  auto cameras = cameras_;
  require<std::invalid_argument>(camera < cameras.size(), "there is no camera ", camera, " for this mask");
  auto& entry = cameras[camera];
  entry.mask = "masks/" + entry.name + ".png";
  makeFolder(directory_, "masks");
  writeMask(directory_ + '/' + entry.mask, mask, entry.intrinsics, entry.name);
  write(std::move(cameras));
}

}  // namespace cloud_colorizer
