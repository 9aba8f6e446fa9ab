// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause

/// A view: one image of one camera with its pose.
#pragma once

#include <Eigen/Geometry>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <opencv2/core.hpp>
#include <string>
#include <vector>

#include "cloud_colorizer/camera/camera.hpp"

namespace cloud_colorizer {

/// What the numbers of a camera's images are: colours; a quantity that was measured, such as a temperature; numbers
/// that stand for classes; a score of each class, one a channel.
enum class ImageKind { kColor, kRadiometric, kLabels, kLogits };
std::vector<std::string> enumNames(ImageKind);  ///< color, radiometric, labels, logits

/// What the images of a camera tell of a point.
struct Quantity {
  ImageKind kind = ImageKind::kColor;
  std::string name;              ///< of its field in the map; empty for colours
  double scale = 1, offset = 0;  ///< radiometric: value = scale * number + offset
  std::string names;             ///< labels, logits: a file that tells what the numbers mean; empty: none

  /// Throws std::invalid_argument: a name that no field can have, a scale that is 0 or not finite.
  void check() const;
};
/// Whether two cameras tell of the same: their views are fused.
inline bool isSame(const Quantity& a, const Quantity& b) {
  return a.kind == b.kind && a.name == b.name;
}

struct View {
  std::uint32_t camera = 0;  ///< index into the recording's cameras
  double stamp = 0;          ///< s, of the image, after the camera's time offset
  Eigen::Isometry3d map_from_camera = Eigen::Isometry3d::Identity();  ///< optical frame to map, relative to the origin
  Twist readout_motion = Twist::Zero();  ///< of a rolling shutter, from the first row to the last, in the frame of the
                                         ///< camera; map_from_camera is then that of the middle row
  std::string image;                     ///< file, relative to the recording
  std::string mask;  ///< likewise: black where this view must not colour; empty: none but its camera's
};

/// Image of a view: CV_8U, CV_16U or CV_32F with m channels; colour images are RGB (not BGR). Shared, never written to.
using ImageSource = std::function<std::shared_ptr<const cv::Mat>(std::size_t view)>;

/// What makes the values of one view comparable with the others': corrected = gain * brightening * value + offset, by
/// channel. Empty arrays mean gain 1 and offset 0.
struct Exposure {
  Eigen::ArrayXf gain;                                 ///< one a channel
  Eigen::ArrayXf offset;                               ///< one a channel, in the units of the values
  Eigen::Array2f vignetting = Eigen::Array2f::Zero();  ///< a, b of the camera; zeros: none

  /// exp(a r^2 + b r^4) at pixel (u, v) of an image of that size [px], r = 1 at the middle of its left and right ends:
  /// what undoes the darkening outwards.
  float brightening(float u, float v, float width, float height) const {
    if (vignetting[0] == 0 && vignetting[1] == 0) return 1;
    const float x = (2 * u + 1) / width - 1, y = ((2 * v + 1) - height) / width, r2 = x * x + y * y;
    return std::exp(vignetting[0] * r2 + vignetting[1] * r2 * r2);
  }
};

/// Pose and exposure that a view is used with: those of the recording, or what the alignment found.
struct CorrectedView {
  Eigen::Isometry3d map_from_camera = Eigen::Isometry3d::Identity();
  Exposure exposure;
  float weight = 1;  ///< 0 to 1, of its observations
};

}  // namespace cloud_colorizer
