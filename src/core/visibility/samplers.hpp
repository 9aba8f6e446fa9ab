// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause

/// Images between their pixels.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <opencv2/core.hpp>

#include "cloud_colorizer/camera/view.hpp"

namespace cloud_colorizer {

/// The value of each channel at (u, v) px; neighbours beyond the border repeat it.
template <class T>
void sampleBilinear(const cv::Mat& image, float u, float v, float* out) {
  const int channels = image.channels();
  const float x = std::min(std::max(u, 0.0F), static_cast<float>(image.cols - 1));
  const float y = std::min(std::max(v, 0.0F), static_cast<float>(image.rows - 1));
  const int left = static_cast<int>(x), top = static_cast<int>(y);
  const int right = std::min(left + 1, image.cols - 1), bottom = std::min(top + 1, image.rows - 1);
  const float ax = x - static_cast<float>(left), ay = y - static_cast<float>(top);
  const T *const above = image.ptr<T>(top), *const below = image.ptr<T>(bottom);
  for (int c = 0; c < channels; ++c) {
    const auto a = static_cast<float>(above[left * channels + c]), b = static_cast<float>(above[right * channels + c]);
    const auto d = static_cast<float>(below[left * channels + c]), e = static_cast<float>(below[right * channels + c]);
    const float upper = a + ax * (b - a), lower = d + ax * (e - d);
    out[c] = upper + ay * (lower - upper);
  }
}

/// The value of each channel of the nearest pixel.
template <class T>
void sampleNearest(const cv::Mat& image, float u, float v, float* out) {
  const int channels = image.channels();
  const int x = std::min(std::max(static_cast<int>(std::lround(u)), 0), image.cols - 1);
  const int y = std::min(std::max(static_cast<int>(std::lround(v)), 0), image.rows - 1);
  const T* const pixel = image.ptr<T>(y) + static_cast<std::ptrdiff_t>(x) * channels;
  std::copy(pixel, pixel + channels, out);
}

using Sampler = void (*)(const cv::Mat& image, float u, float v, float* out);

/// The number of a class between two others is a third class.
template <class T>
Sampler samplerOf(ImageKind kind) {
  return kind == ImageKind::kLabels ? sampleNearest<T> : sampleBilinear<T>;
}

/// For images of the type CV_8U, CV_16U or CV_32F; null for others.
inline Sampler samplerOf(int depth, ImageKind kind) {
  if (depth == CV_8U) return samplerOf<std::uint8_t>(kind);
  if (depth == CV_16U) return samplerOf<std::uint16_t>(kind);
  return depth == CV_32F ? samplerOf<float>(kind) : nullptr;
}

}  // namespace cloud_colorizer
