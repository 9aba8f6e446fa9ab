// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause
#include "camera/pixels.hpp"

#include <cmath>

namespace cloud_colorizer {

int bitsOf(const cv::Mat& image) {
  double most = 0;
  cv::minMaxIdx(image.reshape(1), nullptr, &most);
  for (const int bits : {10, 12, 14}) {
    if (most < std::ldexp(1, bits)) return bits;
  }
  return 16;
}

cv::Mat scaledTo16Bits(const cv::Mat& image, int bits) {
  return image.depth() == CV_16U && bits < 16 ? cv::Mat(image * std::ldexp(1, 16 - bits)) : image;
}

cv::Mat opaquePixels(const cv::Mat& image) {
  if (image.channels() != 4) return {};
  cv::Mat alpha;
  cv::extractChannel(image, alpha, 3);
  double least = 0, most = 0;
  cv::minMaxIdx(alpha, &least, &most);
  if (least == most) return {};
  return alpha >= most;
}

}  // namespace cloud_colorizer
