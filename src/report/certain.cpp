// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause
#include "report/certain.hpp"

#include <algorithm>
#include <vector>

#include "visibility/moving.hpp"

namespace cloud_colorizer {
namespace {

constexpr std::size_t kMostViews = 60, kMostPoints = 20000;
constexpr float kSameRange = 0.02F;  // share by which a range may differ from the point's

/// Whether a pixel is where observations are made.
bool isInside(const Eigen::Vector2f& pixel, const Intrinsics& k, const cv::Mat& mask) {
  const auto border = static_cast<float>(kImageBorder);
  const float right = static_cast<float>(k.width - 1) - border, bottom = static_cast<float>(k.height - 1) - border;
  if (!(pixel.x() >= border && pixel.y() >= border && pixel.x() <= right && pixel.y() <= bottom)) return false;
  return mask.empty() || mask.at<std::uint8_t>(static_cast<int>(pixel.y()), static_cast<int>(pixel.x())) != 0;
}

std::vector<cv::Mat> masksOf(const Recording& recording) {
  std::vector<cv::Mat> masks;
  for (std::size_t camera = 0; camera < recording.cameras().size(); ++camera) {
    masks.push_back(recording.readMask(camera));
  }
  return masks;
}

}  // namespace

nlohmann::json certainlySeenColored(Workspace& work, const MapSample& sample) {
  const Recording& recording = work.recording();
  const std::vector<std::size_t> views = work.colorViews();
  if (recording.scans().empty() || views.empty() || sample.size() == 0) return nullptr;
  const std::vector<cv::Mat> masks = masksOf(recording);
  const auto reach = static_cast<float>(work.params().depth.reach());
  const std::size_t view_step = std::max<std::size_t>(1, views.size() / kMostViews);
  const std::size_t point_step = std::max<std::size_t>(1, sample.size() / kMostPoints);
  std::vector<bool> is_seen(sample.size(), false);
  for (std::size_t k = view_step / 2; k < views.size(); k += view_step) {
    const std::size_t view = views[k];
    const Eigen::Isometry3d& pose = work.corrections()[view].map_from_camera;
    const auto space = work.emptySpace(view, pose);
    if (!space || space->knowsNothing()) continue;
    const Eigen::Isometry3f camera_from_map = pose.inverse().cast<float>();
    const Camera& camera = work.cameraOf(view);
    for (std::size_t i = 0; i < sample.size(); i += point_step) {
      if (is_seen[i] || sample.moving[i] >= kMovingShare) continue;
      const Eigen::Vector3f point =
          camera_from_map * Eigen::Map<const Eigen::Vector3f>(sample.positions.data() + 3 * i);
      if (!camera.mayShow(point, 0) || !(point.squaredNorm() <= reach * reach)) continue;
      const auto pixel = camera.project(point);
      if (!pixel || !isInside(*pixel, camera.intrinsics(), masks[recording.views()[view].camera])) continue;
      is_seen[i] = space->measured(point, kSameRange);
    }
  }
  std::size_t seen = 0, colored = 0;
  for (std::size_t i = 0; i < sample.size(); ++i) {
    if (!is_seen[i]) continue;
    ++seen;
    colored += sample.counts[i] > 0 ? 1 : 0;
  }
  if (seen == 0) return nullptr;
  return static_cast<double>(colored) / static_cast<double>(seen);
}

}  // namespace cloud_colorizer
