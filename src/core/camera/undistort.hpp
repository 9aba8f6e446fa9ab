// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause

/// Images of any camera as a pinhole camera would have taken them.
#pragma once

#include <opencv2/core.hpp>

#include "cloud_colorizer/camera/camera.hpp"

namespace cloud_colorizer {

/// The same focal lengths, principal point and size [px], without distortion: what lies beyond is cut off.
Intrinsics pinholeOf(const Intrinsics& intrinsics);

/// For cv::remap: where the image of `camera` shows what each pixel of pinholeOf() shows; (-1, -1) where it does not.
cv::Mat2f undistortionMap(const Intrinsics& camera);

}  // namespace cloud_colorizer
