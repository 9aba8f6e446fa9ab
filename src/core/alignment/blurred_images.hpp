// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause

/// Blurred images, and their values and gradients at points.
#pragma once

#include <Eigen/Core>
#include <memory>
#include <opencv2/core.hpp>
#include <vector>

#include "cloud_colorizer/alignment/align.hpp"

namespace cloud_colorizer::alignment {

/// A Gaussian blur of an image, stored as coarsely as the blur allows.
struct BlurredImage {
  cv::Mat1w grey;     ///< grey level times kGreyScale
  cv::Mat1b invalid;  ///< share of saturated, black or masked pixels under the blur, 0 to 255
  float step = 1;     ///< px of the full image to a pixel of this one

  static constexpr float kGreyScale = 128;
};

/// Of an RGB or grey 8-bit image. Saturated is above 250 in any channel, black below 5 in all of them. `mask` may be
/// null.
BlurredImage blurImage(const cv::Mat& image, const cv::Mat* mask, double sigma);

struct GreySample {
  float value = 0;                 ///< grey level
  Eigen::Vector2f gradient{0, 0};  ///< grey levels to a px of the full image
  bool valid = false;              ///< inside, and not saturated, black or masked
};
GreySample sampleGrey(const BlurredImage& image, const Eigen::Vector2d& pixel);

/// The blurred images of all views at one sigma: as many as the memory limit allows are kept, the others are made
/// anew each time. Views may be asked for from several threads, one thread a view.
class BlurredImages {
 public:
  BlurredImages(const AlignmentInput& input, double sigma);
  std::shared_ptr<const BlurredImage> get(std::size_t view) const;
  double sigma() const { return sigma_; }  ///< px

 private:
  const AlignmentInput* input_;
  double sigma_;
  mutable std::vector<std::shared_ptr<const BlurredImage>> kept_;
};

/// Loads the view's image and checks it: CV_8U, 1 or 3 channels, the camera's size. Throws std::invalid_argument.
std::shared_ptr<const cv::Mat> loadImage(const AlignmentInput& input, std::size_t view);
std::shared_ptr<const cv::Mat> loadMask(const AlignmentInput& input, std::size_t view);

}  // namespace cloud_colorizer::alignment
