// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause

/// Pictures of a held-out image and of what a map predicts for it.
#pragma once

#include <string>
#include <vector>

#include "evaluation/seen_image.hpp"

namespace cloud_colorizer {

/// Writes the image (RGB), the predicted colours of the points in use, both over each other, and the error.
void savePictures(const std::string& path, const std::string& method, const SeenImage& seen, const Values& predicted,
                  const std::vector<std::uint8_t>& use, const cv::Mat3b& image);

}  // namespace cloud_colorizer
