// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause

/// Arrays of numpy: what keeps images of any number of channels, and of floats.
#pragma once

#include <cstdint>
#include <opencv2/core.hpp>
#include <vector>

namespace cloud_colorizer {

bool isNpy(const std::vector<std::uint8_t>& bytes);

/// The array of a .npy file, rows x columns or rows x columns x channels, of uint8, uint16, float16 or float32; CV_8U,
/// CV_16U or CV_32F. Throws std::runtime_error with the reason.
cv::Mat matOfNpy(const std::vector<std::uint8_t>& bytes);

/// Of CV_8U, CV_16U or CV_32F.
std::vector<std::uint8_t> npyOf(const cv::Mat& image);

}  // namespace cloud_colorizer
