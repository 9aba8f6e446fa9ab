// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause

/// Blurred images, and their values and gradients at points.
///
/// An image is decoded once, and made small once: to at most about 2 megapixels, for more do not place a camera better
/// than the map is good. Whatever a stage wants is blurred from that. Cost of a view: its decoding, then 20 ns a small
/// pixel and blur.
#pragma once

#include <Eigen/Core>
#include <memory>
#include <opencv2/core.hpp>
#include <vector>

#include "cloud_colorizer/alignment/align.hpp"

namespace cloud_colorizer::alignment {

/// Pixels of a camera's image to a pixel of its small image, along either side.
int smallStep(const Intrinsics& intrinsics);

/// Grey levels of an image, and what of it tells nothing.
struct SmallImage {
  cv::Mat1b grey;
  cv::Mat1b invalid;  ///< share of saturated, black or masked pixels, 0 to 255, of kInvalidCell x kInvalidCell pixels
                      ///< of `grey`; empty: none
  int step = 1;       ///< px of the image to a pixel of this one

  static constexpr int kInvalidCell = 4;
};

/// Of an RGB or grey 8-bit image. Saturated is above 250 in any channel, black below 5 in all of them. `mask` may be
/// null.
SmallImage shrinkImage(const cv::Mat& image, const cv::Mat* mask, int step);

/// A Gaussian blur, stored as coarsely as the blur allows.
struct BlurredImage {
  cv::Mat1w grey;          ///< grey level times kGreyScale
  cv::Mat1b invalid;       ///< as SmallImage::invalid, blurred
  float step = 1;          ///< px of the full image to a pixel of `grey`
  float invalid_step = 1;  ///< and of `invalid`

  static constexpr float kGreyScale = 128;
};
/// `sigma`: px of the full image.
BlurredImage blurImage(const SmallImage& image, double sigma);

struct GreySample {
  float value = 0;                 ///< grey level
  Eigen::Vector2f gradient{0, 0};  ///< grey levels to a px of the full image
  bool valid = false;              ///< inside, and not saturated, black or masked
};
GreySample sampleGrey(const BlurredImage& image, const Eigen::Vector2d& pixel);

/// The small images of all views: as many as the memory limit allows are kept, the others are made anew each time.
/// Views may be asked for from several threads, one thread a view.
class SmallImages {
 public:
  explicit SmallImages(const AlignmentInput& input) : input_(&input), kept_(input.views.size()) {}
  std::shared_ptr<const SmallImage> get(std::size_t view) const;

 private:
  const AlignmentInput* input_;
  mutable std::vector<std::shared_ptr<const SmallImage>> kept_;
};

/// The blurred images of all views at one sigma, kept in the same way.
class BlurredImages {
 public:
  /// `sigma`: px of the small images.
  BlurredImages(const AlignmentInput& input, const SmallImages& images, double sigma);
  std::shared_ptr<const BlurredImage> get(std::size_t view) const;
  double sigma(std::size_t view) const;  ///< px of its full image

 private:
  const AlignmentInput* input_;
  const SmallImages* images_;
  double sigma_;
  mutable std::vector<std::shared_ptr<const BlurredImage>> kept_;
};

/// Loads the view's image and checks it: CV_8U, 1 or 3 channels, the camera's size. Throws std::invalid_argument.
std::shared_ptr<const cv::Mat> loadImage(const AlignmentInput& input, std::size_t view);
std::shared_ptr<const cv::Mat> loadMask(const AlignmentInput& input, std::size_t view);

}  // namespace cloud_colorizer::alignment
