// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause
#include "alignment/blurred_images.hpp"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "cloud_colorizer/base/check.hpp"

namespace cloud_colorizer::alignment {
namespace {

constexpr int kSaturated = 250, kBlack = 5;               // of 255
constexpr double kMaxPixels = 2.1e6;                      // of a small image: full HD
constexpr double kSmallShare = 0.2, kBlurredShare = 0.4;  // of the memory; the rest is for what the views see
constexpr int kInvalidShare = 40;  // of 255: more of the blur than that is saturated, black or masked

// 255 where a pixel tells nothing: channels beyond these bounds carry no information about the exposure.
cv::Mat1b unusablePixels(const cv::Mat& image, const cv::Mat* mask) {
  cv::Mat highest = image;
  if (image.channels() == 3) {
    cv::Mat planes[3];
    cv::split(image, planes);
    cv::max(planes[0], planes[1], highest);
    cv::max(highest, planes[2], highest);
  }
  cv::Mat1b unusable;
  cv::inRange(highest, kBlack, kSaturated, unusable);
  if (mask) unusable.setTo(0, *mask == 0);
  cv::bitwise_not(unusable, unusable);
  return unusable;
}

// Whether a view's share of the memory is enough: each has an equal claim, so that what is kept does not depend on the
// order of the threads.
bool mayKeep(const AlignmentInput& input, std::size_t view, double bytes, double share) {
  return static_cast<double>(view + 1) * bytes < share * 1e6 * input.memory_limit;
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

int smallStep(const Intrinsics& intrinsics) {
  const double pixels = static_cast<double>(intrinsics.width) * intrinsics.height;
  return std::max(1, static_cast<int>(std::ceil(std::sqrt(pixels / kMaxPixels))));
}

SmallImage shrinkImage(const cv::Mat& image, const cv::Mat* mask, int step) {
  SmallImage result;
  result.step = step;
  cv::Mat grey = image;
  if (image.channels() == 3) cv::cvtColor(image, grey, cv::COLOR_RGB2GRAY);
  result.grey = halve(grey, step);
  const cv::Mat1b unusable = unusablePixels(image, mask);
  if (cv::countNonZero(unusable) > 0) {
    // Cells that reach over the border as well: what lies beyond it is as its nearest pixel.
    const int side = step * SmallImage::kInvalidCell;
    const auto missing = [&](int size) { return (side - size % side) % side; };
    cv::Mat1b padded;
    cv::copyMakeBorder(unusable, padded, 0, missing(unusable.rows), 0, missing(unusable.cols), cv::BORDER_REPLICATE);
    result.invalid = halve(padded, side);
  }
  return result;
}

BlurredImage blurImage(const SmallImage& image, double sigma) {
  const double small_sigma = sigma / image.step;
  int step = 1;
  while (2 * step <= small_sigma / 1.4 && std::min(image.grey.cols, image.grey.rows) / (2 * step) >= 16) step *= 2;
  // Averaging step x step pixels blurs already, with this variance.
  const double rest = std::sqrt(std::max(0.0, small_sigma * small_sigma - (step * step - 1) / 12.0)) / step;
  cv::Mat grey;
  halve(image.grey, step).convertTo(grey, CV_16U, BlurredImage::kGreyScale);
  blurInPlace(grey, rest);
  cv::Mat invalid = image.invalid.clone();
  if (!invalid.empty()) blurInPlace(invalid, small_sigma / SmallImage::kInvalidCell);
  return {grey, invalid, static_cast<float>(step * image.step),
          static_cast<float>(image.step * SmallImage::kInvalidCell)};
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
  sample.valid =
      image.invalid.empty() || image.invalid(static_cast<int>((pixel.y() + 0.5) / image.invalid_step),
                                             static_cast<int>((pixel.x() + 0.5) / image.invalid_step)) < kInvalidShare;
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
  auto mask = input.masks(view);
  if (!mask || mask->empty()) return nullptr;
  const Intrinsics& intrinsics = input.cameras[input.views[view].camera].intrinsics();
  require<std::invalid_argument>(
      mask->type() == CV_8UC1 && mask->cols == intrinsics.width && mask->rows == intrinsics.height, "the mask of view ",
      view, " must be CV_8UC1 of its camera's size");
  return mask;
}

std::shared_ptr<const SmallImage> SmallImages::get(std::size_t view) const {
  if (kept_[view]) return kept_[view];
  const auto image = loadImage(*input_, view);
  const auto mask = loadMask(*input_, view);
  const int step = smallStep(input_->cameras[input_->views[view].camera].intrinsics());
  auto small = std::make_shared<SmallImage>(shrinkImage(*image, mask.get(), step));
  if (mayKeep(*input_, view, 1.1 * static_cast<double>(small->grey.total()), kSmallShare)) kept_[view] = small;
  return small;
}

BlurredImages::BlurredImages(const AlignmentInput& input, const SmallImages& images, double sigma)
    : input_(&input), images_(&images), sigma_(sigma), kept_(input.views.size()) {}

double BlurredImages::sigma(std::size_t view) const {
  return sigma_ * smallStep(input_->cameras[input_->views[view].camera].intrinsics());
}

std::shared_ptr<const BlurredImage> BlurredImages::get(std::size_t view) const {
  if (kept_[view]) return kept_[view];
  auto blurred = std::make_shared<BlurredImage>(blurImage(*images_->get(view), sigma(view)));
  if (mayKeep(*input_, view, 2.1 * static_cast<double>(blurred->grey.total()), kBlurredShare)) kept_[view] = blurred;
  return blurred;
}

}  // namespace cloud_colorizer::alignment
