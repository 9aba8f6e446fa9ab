// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause

/// The cameras of a recording that is being filled: cameras.yaml, and the folders of images and masks.
#pragma once

#include <opencv2/core.hpp>
#include <string>
#include <vector>

#include "cloud_colorizer/recording/recording.hpp"

namespace cloud_colorizer {

class CameraList {
 public:
  CameraList(const std::string& directory, std::vector<RecordedCamera> cameras);

  const std::vector<RecordedCamera>& cameras() const { return cameras_; }
  /// Or adds it; see Recorder::setCamera.
  std::uint32_t find(const std::string& name, const Intrinsics& intrinsics, const Quantity& quantity);
  void setMask(std::uint32_t camera, const cv::Mat1b& mask);

 private:
  void write(std::vector<RecordedCamera> cameras);
  std::string copiedNames(const Quantity& quantity) const;

  std::string directory_;
  std::vector<RecordedCamera> cameras_;
};

}  // namespace cloud_colorizer
