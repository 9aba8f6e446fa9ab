// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause
#include "evaluation/seen_image.hpp"

#include "visibility/samplers.hpp"

namespace cloud_colorizer {
namespace {

using Eigen::Index;

Eigen::Vector3f valueAt(const cv::Mat3b& image, const Eigen::Vector2f& pixel) {
  Eigen::Vector3f value;
  sampleBilinear<std::uint8_t>(image, pixel.x(), pixel.y(), value.data());
  return value;
}

constexpr float kSaturated = 250;
constexpr float kRangeShare = 0.01F;  // by which a point's range and the measured one may differ

}  // namespace

std::optional<Eigen::Vector2f> HeldoutView::pixelOf(const Eigen::Vector3f& point) const {
  const auto border = static_cast<float>(kImageBorder);
  const auto right = static_cast<float>(image.cols - 1) - border, bottom = static_cast<float>(image.rows - 1) - border;
  auto pixel = camera.project(point);
  if (!pixel || pixel->x() < border || pixel->y() < border || pixel->x() > right || pixel->y() > bottom) return {};
  if (mask.empty()) return pixel;
  if (mask.at<std::uint8_t>(cv::Point(cvRound(pixel->x()), cvRound(pixel->y()))) == 0) return {};
  return pixel;
}

std::vector<Index> HeldoutView::measured(PointsRef points) const {
  std::vector<Index> found;
  if (!empty_space) return found;
  const Eigen::Isometry3f camera_from_map = view.map_from_camera.inverse().cast<float>();
  for (Index p = 0; p < points.cols(); ++p) {
    const Eigen::Vector3f local = camera_from_map * points.col(p);
    if (pixelOf(local) && empty_space->measured(local, kRangeShare)) found.push_back(p);
  }
  return found;
}

SeenImage HeldoutView::at(PointsRef points, const Surfels& surfels, const Params& params) const {
  const Eigen::Isometry3f camera_from_map = view.map_from_camera.inverse().cast<float>();
  DepthSplatter splatter(camera, camera_from_map, params.depth, empty_space);
  splatter.add(points, surfels);
  const DepthImage depth = splatter.finish();
  SeenImage seen;
  std::vector<Eigen::Vector3f> values;
  for (Index p = 0; p < points.cols(); ++p) {
    const Eigen::Vector3f local = camera_from_map * surfels.onSurface(p, points.col(p));
    if (local.z() <= 0 || local.norm() > static_cast<float>(params.depth.reach())) continue;
    const auto pixel = pixelOf(camera_from_map * points.col(p));
    if (!pixel) continue;
    const Eigen::Vector3f normal = camera_from_map.linear() * surfels.normals.col(p);
    if (depth.test(*pixel, local, normal, surfels.radii[p], params.depth, surfels.thickness(p)) != Visibility::kVisible)
      continue;
    const Eigen::Vector3f value = valueAt(image, *pixel);
    if (value.maxCoeff() >= kSaturated) continue;  // what is brighter than the image holds tells no colour
    seen.points.push_back(p);
    seen.pixels.push_back(*pixel);
    seen.depths.push_back(local.z());
    seen.pixel_radii.push_back(surfels.radii[p] * static_cast<float>(camera.intrinsics().fx) / local.z());
    values.push_back(value);
  }
  seen.values.resize(3, static_cast<Index>(values.size()));
  for (std::size_t k = 0; k < values.size(); ++k) seen.values.col(static_cast<Index>(k)) = values[k];
  return seen;
}

SeenImage HeldoutView::from(const Eigen::Isometry3d& map_from_camera, PointsRef points, const SeenImage& seen) const {
  const Eigen::Isometry3f camera_from_map = map_from_camera.inverse().cast<float>();
  SeenImage moved = seen;
  for (std::size_t k = 0; k < seen.points.size(); ++k) {
    const auto pixel = camera.project(camera_from_map * points.col(seen.points[k]));
    if (!pixel) continue;
    moved.pixels[k] = *pixel;
    moved.values.block<3, 1>(0, static_cast<Index>(k)) = valueAt(image, *pixel);
  }
  return moved;
}

}  // namespace cloud_colorizer
