// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause
#include "report/edge_pictures.hpp"

#include <algorithm>
#include <cmath>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <string>
#include <vector>

#include "base/parallel.hpp"
#include "map/stages.hpp"
#include "report/map_sample.hpp"

namespace cloud_colorizer {
namespace {

using nlohmann::json;

constexpr std::size_t kMostCameras = 6;
constexpr int kWidth = 640;  // px
constexpr int kQuality = 80;

/// Cells on the near side of a step in depth.
std::vector<cv::Point> edgesOf(const DepthImage& image) {
  constexpr float kStep = 0.08F;  // of the depth
  const cv::Mat1f& depth = image.depth;
  std::vector<cv::Point> edges;
  for (int y = 0; y + 1 < depth.rows; ++y) {
    for (int x = 0; x + 1 < depth.cols; ++x) {
      const float here = depth(y, x);
      for (const float there : {depth(y, x + 1), depth(y + 1, x)}) {
        const float nearer = std::min(here, there), farther = std::max(here, there);
        if (!std::isfinite(nearer) || farther <= (1 + kStep) * nearer) continue;
        edges.emplace_back(x, y);
        break;
      }
    }
  }
  return edges;
}

std::string draw(const cv::Mat& rgb, const DepthImage& depth, const cv::Scalar& color) {
  cv::Mat image;
  const double scale = static_cast<double>(kWidth) / rgb.cols;
  cv::resize(rgb, image, {}, scale, scale, cv::INTER_AREA);
  if (image.channels() == 1) cv::cvtColor(image, image, cv::COLOR_GRAY2RGB);
  cv::cvtColor(image, image, cv::COLOR_RGB2BGR);
  const double cell = static_cast<double>(depth.cell_size) * scale;
  for (const cv::Point& at : edgesOf(depth)) {
    const cv::Point center(static_cast<int>((at.x + 0.5) * cell), static_cast<int>((at.y + 0.5) * cell));
    cv::rectangle(image, center, center + cv::Point(1, 1), color, cv::FILLED);
  }
  std::vector<std::uint8_t> bytes;
  cv::imencode(".jpg", image, bytes, {cv::IMWRITE_JPEG_QUALITY, kQuality});
  return "data:image/jpeg;base64," + base64Of(bytes.data(), bytes.size());
}

struct Choice {
  std::size_t view = 0;
  const char* which = "";
  double pixels = 0;
};

/// Those of a camera that the alignment moved least and most; nothing where it moved none.
std::vector<Choice> extremes(const json& views, std::size_t camera) {
  Choice least{0, "moved least", -1}, most{0, "moved most", -1};
  if (!views.is_object()) return {};
  for (const json& row : views["rows"]) {
    const double pixels = row[6];
    if (row[1].get<std::size_t>() != camera || row[3].get<double>() <= 0) continue;
    const auto view = row[0].get<std::size_t>();
    if (least.pixels < 0 || pixels < least.pixels) least.view = view, least.pixels = pixels;
    if (pixels > most.pixels) most.view = view, most.pixels = pixels;
  }
  if (most.pixels <= 0) return {};
  return least.view == most.view ? std::vector<Choice>{most} : std::vector<Choice>{least, most};
}

std::vector<Choice> middleView(const Workspace& work, std::size_t camera) {
  std::vector<std::size_t> own;
  for (const std::size_t view : work.colorViews()) {
    if (work.recording().views()[view].camera == camera) own.push_back(view);
  }
  if (own.empty()) return {};
  return {{own[own.size() / 2], "in the middle of the drive", 0}};
}

}  // namespace

json edgePictures(Workspace& work, const json& views, const Callbacks& callbacks) {
  json pictures = json::array();
  const Callbacks turns = takingTurns(callbacks);
  const std::size_t num_cameras = std::min(work.recording().cameras().size(), kMostCameras);
  for (std::size_t camera = 0; camera < num_cameras; ++camera) {
    std::vector<Choice> choices = extremes(views, camera);
    if (choices.empty()) choices = middleView(work, camera);
    for (const Choice& choice : choices) {
      if (!work.files().hasDepth(choice.view)) continue;
      const auto image = work.image(choice.view);
      json picture = {{"camera", work.recording().cameras()[camera].name},
                      {"view", choice.view},
                      {"which", choice.which},
                      {"pixels", choice.pixels}};
      if (choice.pixels > 0) {
        const auto& given = work.recording().views()[choice.view].map_from_camera;
        picture["before"] = draw(*image, renderDepth(work, choice.view, given, turns), cv::Scalar(40, 40, 235));
      }
      picture["after"] = draw(*image, work.files().readDepth(choice.view), cv::Scalar(60, 210, 60));
      pictures.push_back(std::move(picture));
    }
  }
  return pictures;
}

}  // namespace cloud_colorizer
