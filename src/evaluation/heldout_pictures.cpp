// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause
#include "evaluation/heldout_pictures.hpp"

#include <algorithm>
#include <numeric>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "cloud_colorizer/base/check.hpp"
#include "cloud_colorizer/picture/picture.hpp"

namespace cloud_colorizer {
namespace {

using Eigen::Index;

/// Points as squares of their size, far ones first, over `background` (BGR).
cv::Mat3b drawSeen(const SeenImage& seen, const Values& colors, const std::vector<std::uint8_t>& use,
                   const cv::Mat3b& background) {
  std::vector<std::size_t> order(seen.points.size());
  std::iota(order.begin(), order.end(), 0);
  std::stable_sort(order.begin(), order.end(), [&](auto a, auto b) { return seen.depths[a] > seen.depths[b]; });
  const float widest = std::max(0.5F, 0.006F * static_cast<float>(background.cols));  // else lone points hide others
  cv::Mat3b picture = background.clone();
  for (const std::size_t k : order) {
    if (use[k] == 0) continue;
    const float half = std::clamp(seen.pixel_radii[k], 0.5F, widest);
    const cv::Point low(cvRound(seen.pixels[k].x() - half), cvRound(seen.pixels[k].y() - half));
    const cv::Point high(cvRound(seen.pixels[k].x() + half), cvRound(seen.pixels[k].y() + half));
    const auto column = static_cast<Index>(k);
    cv::rectangle(picture, low, high,
                  cv::Scalar(static_cast<double>(colors(2, column)), static_cast<double>(colors(1, column)),
                             static_cast<double>(colors(0, column))),
                  cv::FILLED);
  }
  return picture;
}

/// A panel of a picture; photographs of many megapixels are shrunk.
cv::Mat panel(const cv::Mat& picture) {
  constexpr int kWidest = 560;
  if (picture.cols <= kWidest) return picture;
  cv::Mat small;
  cv::resize(picture, small, {kWidest, picture.rows * kWidest / picture.cols}, 0, 0, cv::INTER_AREA);
  return small;
}

}  // namespace

void savePictures(const std::string& path, const std::string& method, const SeenImage& seen, const Values& predicted,
                  const std::vector<std::uint8_t>& use, const cv::Mat3b& image) {
  constexpr float kWorstError = 60;
  const Eigen::VectorXf errors = (predicted - seen.values).cwiseAbs().colwise().mean();
  cv::Mat3b bgr;
  cv::cvtColor(image, bgr, cv::COLOR_RGB2BGR);
  const cv::Mat3b black(bgr.size(), cv::Vec3b(0, 0, 0));
  cv::Mat3b dark;
  bgr.convertTo(dark, CV_8U, 0.35);
  const cv::Mat left = besideEachOther({panel(bgr), panel(drawSeen(seen, predicted, use, black))}, {"image", method});
  const cv::Mat right = besideEachOther({panel(drawSeen(seen, predicted, use, dark)),
                                         panel(drawSeen(seen, colorScale(errors, 0, kWorstError), use, black))},
                                        {"overlay", "error, 0 to 60"});
  cv::Mat all;
  cv::vconcat(left, right, all);
  require(cv::imwrite(path, all), "cannot write ", path);
}

}  // namespace cloud_colorizer
