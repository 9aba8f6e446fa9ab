// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause
#include "camera/values.hpp"

#include <algorithm>
#include <cmath>

#include "camera/npy.hpp"
#include "cloud_colorizer/base/check.hpp"

namespace cloud_colorizer {
namespace {

constexpr double kSumTolerance = 0.01;  // of the probabilities of a pixel, from 1

/// Whether each pixel of some has numbers from 0 to 1 that add up to 1.
bool areProbabilities(const cv::Mat& image) {
  const cv::Mat some = image.row(image.rows / 2).reshape(1, image.cols);  // a pixel a row
  double least = 0, most = 0;
  cv::minMaxIdx(some, &least, &most);
  if (least < 0 || most > 1 + kSumTolerance) return false;
  cv::Mat sums;
  cv::reduce(some, sums, 1, cv::REDUCE_SUM, CV_64F);
  cv::minMaxIdx(sums, &least, &most);
  return std::abs(least - 1) <= kSumTolerance && std::abs(most - 1) <= kSumTolerance;
}

/// `least`: probability of what a whole number of 0 says.
cv::Mat logarithms(const cv::Mat& image, double scale, double least) {
  cv::Mat result;
  image.convertTo(result, CV_32F, scale, least);
  cv::log(result, result);
  return result;
}

}  // namespace

void requireValues(int type, ImageKind kind, const std::string& what) {
  const bool is_whole = CV_MAT_DEPTH(type) == CV_8U || CV_MAT_DEPTH(type) == CV_16U;
  const bool is_known = is_whole || CV_MAT_DEPTH(type) == CV_32F;
  const int channels = CV_MAT_CN(type);
  const std::string has = " has " + std::to_string(channels) + (channels == 1 ? " channel" : " channels");
  require(is_known, what, " has numbers other than of 8 or 16 bits and floats");
  require(kind != ImageKind::kRadiometric || channels == 1, what, has, "; a radiometric image has one");
  require(kind != ImageKind::kLabels || (channels == 1 && is_whole), what, has, is_whole ? "" : " of floats",
          "; an image of labels has one of whole numbers, the class of each pixel, and no palette");
  require(kind != ImageKind::kLogits || channels > 1, what, has, "; logits have one for each class");
}

cv::Mat shownValues(const cv::Mat& image, ImageKind kind) {
  constexpr double kLeast = 1e-6;
  if (kind != ImageKind::kLogits) return image;
  if (image.depth() == CV_8U) return logarithms(image, 1 / 255.0, 0.5 / 255);
  if (image.depth() == CV_16U) return logarithms(image, 1 / 65535.0, 0.5 / 65535);
  return areProbabilities(image) ? logarithms(image, 1, kLeast) : image;
}

EncodedImage encodeValues(const cv::Mat& image, const std::string& format) {
  const bool is_whole = image.depth() == CV_8U || image.depth() == CV_16U;
  if (is_whole && image.channels() == 1) return encodeImage(image, format == "jpg" ? "png" : format);
  return {npyOf(image), "npy"};
}

}  // namespace cloud_colorizer
