// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause
#include "camera/pixels.hpp"

#include <algorithm>
#include <cmath>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "cloud_colorizer/base/check.hpp"

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

bool hasShapeOf(cv::Size size, cv::Size other) {
  const double x = static_cast<double>(size.width) / other.width, y = static_cast<double>(size.height) / other.height;
  return std::abs(x - y) * std::min(other.width, other.height) <= 1;
}

cv::Mat1b fittedMask(const cv::Mat& mask, cv::Size image) {
  require<std::invalid_argument>(hasShapeOf(mask.size(), image), "the mask is ", mask.cols, " x ", mask.rows,
                                 ", the image ", image.width, " x ", image.height, "; it must have the image's shape");
  cv::Mat fitted = mask;
  if (mask.size() != image) cv::resize(mask, fitted, image, 0, 0, cv::INTER_NEAREST);
  return fitted;
}

EncodedImage encodeImage(const cv::Mat& image, const std::string& format) {
  EncodedImage result;
  result.extension = format;
  if (format == "ppm" && image.channels() == 1) result.extension = "pgm";
  if ((format == "jpg" && image.depth() == CV_16U) || image.channels() == 4) result.extension = "png";
  const std::vector<int> options = {cv::IMWRITE_PNG_COMPRESSION, 1, cv::IMWRITE_JPEG_QUALITY, 95};
  require(cv::imencode("." + result.extension, image, result.bytes, options), "OpenCV cannot encode a ", image.cols,
          " x ", image.rows, " image as ", result.extension);
  return result;
}

}  // namespace cloud_colorizer
