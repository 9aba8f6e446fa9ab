// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause
#include "alignment/blurred_images.hpp"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "cloud_colorizer/base/check.hpp"

namespace cloud_colorizer::alignment {
namespace {

constexpr int kSaturated = 250, kBlack = 5;  // of 255
constexpr double kImagesShare = 0.5;         // of the memory; the rest is for what the views see
constexpr int kInvalidShare = 40;            // of 255: more of the blur than that is saturated, black or masked

// Channels beyond these bounds carry no information about the exposure.
cv::Mat1b unusablePixels(const cv::Mat& image, const cv::Mat* mask) {
  cv::Mat1b unusable(image.size());
  const int channels = image.channels();
  for (int y = 0; y < image.rows; ++y) {
    const auto* row = image.ptr<std::uint8_t>(y);
    for (int x = 0; x < image.cols; ++x, row += channels) {
      const auto [low, high] = std::minmax_element(row, row + channels);
      const bool masked = mask && mask->at<std::uint8_t>(y, x) == 0;
      static_cast<void>(low);
      unusable(y, x) = masked || *high > kSaturated || *high < kBlack ? 255 : 0;
    }
  }
  return unusable;
}

cv::Mat halve(const cv::Mat& image, int step) {
  if (step == 1) return image;
  const cv::Size size(image.cols / step, image.rows / step);
  cv::Mat small;
  cv::resize(image(cv::Rect(0, 0, size.width * step, size.height * step)), small, size, 0, 0, cv::INTER_AREA);
  return small;
}

void blurInPlace(cv::Mat& image, double sigma) {
  if (sigma > 0.3) cv::GaussianBlur(image, image, cv::Size(0, 0), sigma, sigma, cv::BORDER_REPLICATE);
}

}  // namespace

BlurredImage blurImage(const cv::Mat& image, const cv::Mat* mask, double sigma) {
  int step = 1;
  while (2 * step <= sigma / 1.4 && std::min(image.cols, image.rows) / (2 * step) >= 16) step *= 2;
  // Averaging step x step pixels blurs already, with this variance.
  const double rest = std::sqrt(std::max(0.0, sigma * sigma - (step * step - 1) / 12.0)) / step;
  cv::Mat small = halve(image, step), wide, grey;
  small.convertTo(wide, CV_16U, BlurredImage::kGreyScale);
  if (wide.channels() == 3) {
    cv::cvtColor(wide, grey, cv::COLOR_RGB2GRAY);
  } else {
    grey = wide;
  }
  blurInPlace(grey, rest);
  cv::Mat invalid = halve(unusablePixels(image, mask), step);
  if (cv::countNonZero(invalid) > 0) blurInPlace(invalid, rest);
  return BlurredImage{grey, invalid, static_cast<float>(step)};
}

GreySample sampleGrey(const BlurredImage& image, const Eigen::Vector2d& pixel) {
  GreySample sample;
  const double u = (pixel.x() + 0.5) / image.step - 0.5, v = (pixel.y() + 0.5) / image.step - 0.5;
  const int x = static_cast<int>(std::floor(u)), y = static_cast<int>(std::floor(v));
  if (x < 1 || y < 1 || x + 2 >= image.grey.cols || y + 2 >= image.grey.rows) return sample;
  const auto a = static_cast<float>(u - x), b = static_cast<float>(v - y);
  // Weights of a bilinear value and of the bilinear mean of central differences, on 4 x 4 pixels.
  const float wx[4] = {0, 1 - a, a, 0}, wy[4] = {0, 1 - b, b, 0};
  const float dx[4] = {(a - 1) / 2, -a / 2, (1 - a) / 2, a / 2}, dy[4] = {(b - 1) / 2, -b / 2, (1 - b) / 2, b / 2};
  float value = 0, gx = 0, gy = 0;
  for (int r = 0; r < 4; ++r) {
    const std::uint16_t* row = image.grey.ptr<std::uint16_t>(y - 1 + r) + (x - 1);
    const float c0 = row[0], c1 = row[1], c2 = row[2], c3 = row[3];
    const float along = wx[1] * c1 + wx[2] * c2;
    value += wy[r] * along;
    gy += dy[r] * along;
    gx += wy[r] * (dx[0] * c0 + dx[1] * c1 + dx[2] * c2 + dx[3] * c3);
  }
  const float scale = 1 / BlurredImage::kGreyScale;
  sample.value = value * scale;
  sample.gradient = Eigen::Vector2f(gx, gy) * (scale / image.step);
  sample.valid = image.invalid(y + (b > 0.5F), x + (a > 0.5F)) < kInvalidShare;
  return sample;
}

std::shared_ptr<const cv::Mat> loadImage(const AlignmentInput& input, std::size_t view) {
  auto image = input.images(view);
  const Intrinsics& intrinsics = input.cameras[input.views[view].camera].intrinsics();
  require<std::invalid_argument>(image && image->depth() == CV_8U && (image->channels() == 1 || image->channels() == 3),
                                 "alignment needs 8-bit images with 1 or 3 channels, but view ", view,
                                 " has another type; set align_exposure false and align_poses none for such data");
  require<std::invalid_argument>(image->cols == intrinsics.width && image->rows == intrinsics.height, "image of view ",
                                 view, " is ", image->cols, " x ", image->rows, ", its camera ", intrinsics.width,
                                 " x ", intrinsics.height);
  return image;
}

std::shared_ptr<const cv::Mat> loadMask(const AlignmentInput& input, std::size_t view) {
  if (!input.masks) return nullptr;
  auto mask = input.masks(input.views[view].camera);
  if (!mask || mask->empty()) return nullptr;
  const Intrinsics& intrinsics = input.cameras[input.views[view].camera].intrinsics();
  require<std::invalid_argument>(
      mask->type() == CV_8UC1 && mask->cols == intrinsics.width && mask->rows == intrinsics.height,
      "the mask of camera ", input.views[view].camera, " must be CV_8UC1 of the camera's size");
  return mask;
}

BlurredImages::BlurredImages(const AlignmentInput& input, double sigma)
    : input_(&input), sigma_(sigma), kept_(input.views.size()) {}

std::shared_ptr<const BlurredImage> BlurredImages::get(std::size_t view) const {
  if (kept_[view]) return kept_[view];
  const auto image = loadImage(*input_, view);
  const auto mask = loadMask(*input_, view);
  auto blurred = std::make_shared<BlurredImage>(blurImage(*image, mask.get(), sigma_));
  const double bytes = 3.0 * static_cast<double>(blurred->grey.total());
  // Each view has an equal claim, so that what is kept does not depend on the order of the threads.
  if (static_cast<double>(view + 1) * bytes < kImagesShare * 1e6 * input_->memory_limit) kept_[view] = blurred;
  return blurred;
}

}  // namespace cloud_colorizer::alignment
