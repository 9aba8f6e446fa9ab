// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause

/// Images of what are no colours.
#pragma once

#include <opencv2/core.hpp>
#include <string>
#include <vector>

#include "camera/pixels.hpp"
#include "cloud_colorizer/camera/view.hpp"

namespace cloud_colorizer {

/// Throws std::runtime_error, which begins with `what`, unless an image of that type (CV_8UC1, ...) can be of that
/// kind: radiometric has one channel, labels one of whole numbers, logits more than one.
void requireValues(int type, ImageKind kind, const std::string& what);

/// What the views of that kind show: the numbers, or of logits CV_32FC(k), of which a softmax gives the probability of
/// each class. Probabilities, whole numbers among them, become their logarithms.
cv::Mat shownValues(const cv::Mat& image, ImageKind kind);

/// As a file that keeps every number: `format` (png or ppm) for whole numbers of one channel, else .npy.
EncodedImage encodeValues(const cv::Mat& image, const std::string& format);

}  // namespace cloud_colorizer
