// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause

/// What the numbers of an image mean, where they count, and how they are kept.
#pragma once

#include <cstdint>
#include <opencv2/core.hpp>
#include <string>
#include <vector>

namespace cloud_colorizer {

/// The least of 10, 12, 14 and 16 bits that hold the numbers of an image with 16 bits a channel.
int bitsOf(const cv::Mat& image);
/// Numbers of `bits` bits as 16; images of 8 bits as they are.
cv::Mat scaledTo16Bits(const cv::Mat& image, int bits);

/// CV_8UC1, 0 where an image of four channels is transparent, be it a little, as such pixels have another's colour.
/// Empty where none is, or all are: then the alpha means nothing, as with cameras that leave it 0.
cv::Mat opaquePixels(const cv::Mat& image);

/// Whether one has the shape of the other, larger or smaller by one factor, but for the rounding of the shorter side.
bool hasShapeOf(cv::Size size, cv::Size other);

/// A mask at the size of its image. Throws std::invalid_argument where it has another shape.
cv::Mat1b fittedMask(const cv::Mat& mask, cv::Size image);

/// `format`: ppm (stored as it is; grey becomes pgm), png (compressed as fast as possible), both without loss; or jpg
/// (quality 95; 16-bit images become png). An image with alpha (BGRA) becomes png.
struct EncodedImage {
  std::vector<std::uint8_t> bytes;
  std::string extension;
};
EncodedImage encodeImage(const cv::Mat& image, const std::string& format);

}  // namespace cloud_colorizer
