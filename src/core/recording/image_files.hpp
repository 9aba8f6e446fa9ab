// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause

/// The images and masks of a recording, as files. Errors are std::runtime_error with the path.
#pragma once

#include <opencv2/core.hpp>
#include <string>

#include "cloud_colorizer/recording/recording.hpp"

namespace cloud_colorizer {

/// As cv::imread; empty when the file is no whole image.
cv::Mat decodeFile(const std::string& path, int flags);

/// Where the image is transparent, the mask is 0. The orientation of EXIF is applied only where the turned image has
/// the size of its camera and the other one has not. Throws: undecodable, another size, and of what are no colours,
/// what requireValues() throws.
ViewPixels decodePixels(const std::string& path, const Intrinsics& intrinsics, ImageKind kind = ImageKind::kColor);
cv::Mat decodeMask(const std::string& path, const Intrinsics& intrinsics);

/// Throws std::invalid_argument where it has not the size of the camera, which `owner` names.
void writeMask(const std::string& path, const cv::Mat1b& mask, const Intrinsics& intrinsics, const std::string& owner);

/// Where that of a view's image lies: "images/camera_0/000012.mask.png" of ".../000012.jpg".
std::string maskFileOf(const std::string& image);

/// Black in one is black in both; empty: none.
void addMask(const cv::Mat& mask, cv::Mat& to);

}  // namespace cloud_colorizer
