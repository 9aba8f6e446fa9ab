// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause

/// What the numbers of an image mean.
#pragma once

#include <opencv2/core.hpp>

namespace cloud_colorizer {

/// The least of 10, 12, 14 and 16 bits that hold the numbers of an image with 16 bits a channel.
int bitsOf(const cv::Mat& image);
/// Numbers of `bits` bits as 16; images of 8 bits as they are.
cv::Mat scaledTo16Bits(const cv::Mat& image, int bits);

/// CV_8UC1, 0 where an image of four channels is transparent, be it a little, as such pixels have another's colour.
/// Empty where none is, or all are: then the alpha means nothing, as with cameras that leave it 0.
cv::Mat opaquePixels(const cv::Mat& image);

}  // namespace cloud_colorizer
