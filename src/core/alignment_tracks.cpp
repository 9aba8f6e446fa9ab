// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "cloud_colorizer/alignment/tracks.hpp"

namespace cloud_colorizer::alignment {
namespace {

constexpr float kGrazing = 0.2F;  // cosine of the incidence below which a view tells nothing

// A mixing hash, so that every view drops the same points where it sees too many.
std::uint32_t priority(std::uint32_t point) {
  std::uint32_t h = point * 0x9E3779B1U;
  h ^= h >> 15;
  h *= 0x85EBCA77U;
  return h ^ (h >> 13);
}

// px from each cell to the nearest guard band of a depth edge.
cv::Mat1f distanceToEdges(const DepthImage& depth) {
  cv::Mat1f distance;
  if (cv::countNonZero(depth.edge) == 0) return cv::Mat1f(depth.edge.size(), 1e6F);
  cv::distanceTransform(depth.edge == 0, distance, cv::DIST_L2, 3, CV_32F);
  distance *= depth.cell_size;
  return distance;
}

float distanceToBorder(const Eigen::Vector2f& pixel, const Intrinsics& intrinsics) {
  return std::min({pixel.x(), pixel.y(), static_cast<float>(intrinsics.width - 1) - pixel.x(),
                   static_cast<float>(intrinsics.height - 1) - pixel.y()});
}

float incidence(const Eigen::Vector3f& normal, const Eigen::Vector3f& ray) {
  if (normal.squaredNorm() < 0.5F) return 0.5F;  // no plane: any direction is as good
  return std::abs(normal.dot(ray)) / std::max(ray.norm(), 1e-9F);
}

void keepByPriority(std::vector<Sighting>& sightings, std::size_t max_points) {
  if (sightings.size() <= max_points) return;
  const auto before = [](const Sighting& a, const Sighting& b) { return priority(a.point) < priority(b.point); };
  std::nth_element(sightings.begin(), sightings.begin() + static_cast<std::ptrdiff_t>(max_points), sightings.end(),
                   before);
  sightings.resize(max_points);
  std::sort(sightings.begin(), sightings.end(), [](const auto& a, const auto& b) { return a.point < b.point; });
}

}  // namespace

std::vector<Sighting> findSightings(const AlignmentInput& input, std::size_t view,
                                    const Eigen::Isometry3d& map_from_camera, std::size_t max_points) {
  std::vector<Sighting> sightings;
  const auto depth = input.depth(view, map_from_camera);
  if (!depth || depth->depth.empty()) return sightings;
  const cv::Mat1f edge_distance = distanceToEdges(*depth);
  const Camera& camera = input.cameras[input.views[view].camera];
  const Eigen::Isometry3f camera_from_map = map_from_camera.inverse().cast<float>();
  const auto max_distance = static_cast<float>(input.depth_params.max_view_distance);
  for (Eigen::Index p = 0; p < input.points.cols(); ++p) {
    const Eigen::Vector3f local = camera_from_map * input.points.col(p);
    if (local.norm() > max_distance) continue;
    const auto pixel = camera.project(local);
    if (!pixel) continue;
    const Eigen::Vector3f normal = camera_from_map.linear() * input.surfels.normals.col(p);
    const float cosine = incidence(normal, local);
    if (cosine < kGrazing) continue;
    const auto visibility = depth->test(*pixel, local, normal, input.surfels.radii[p], input.depth_params);
    if (visibility != Visibility::kVisible) continue;
    const int row = std::clamp(static_cast<int>((pixel->y() + 0.5F) / depth->cell_size), 0, edge_distance.rows - 1);
    const int col = std::clamp(static_cast<int>((pixel->x() + 0.5F) / depth->cell_size), 0, edge_distance.cols - 1);
    const float clear = std::min(edge_distance(row, col), distanceToBorder(*pixel, camera.intrinsics()));
    sightings.push_back({static_cast<std::uint32_t>(p), cosine, clear});
  }
  keepByPriority(sightings, max_points);
  return sightings;
}

Tracks makeTracks(const std::vector<std::vector<Sighting>>& by_view, std::size_t num_points) {
  Tracks tracks;
  tracks.offsets.push_back(0);
  tracks.point_offsets.assign(num_points + 1, 0);
  for (std::size_t v = 0; v < by_view.size(); ++v) {
    tracks.sightings.insert(tracks.sightings.end(), by_view[v].begin(), by_view[v].end());
    tracks.views.insert(tracks.views.end(), by_view[v].size(), static_cast<std::uint32_t>(v));
    tracks.offsets.push_back(static_cast<std::uint32_t>(tracks.sightings.size()));
    for (const Sighting& sighting : by_view[v]) ++tracks.point_offsets[sighting.point + 1];
  }
  for (std::size_t p = 0; p < num_points; ++p) tracks.point_offsets[p + 1] += tracks.point_offsets[p];
  std::vector<std::uint32_t> next(tracks.point_offsets.begin(), tracks.point_offsets.end() - 1);
  tracks.by_point.resize(tracks.sightings.size());
  for (std::uint32_t k = 0; k < tracks.sightings.size(); ++k) tracks.by_point[next[tracks.sightings[k].point]++] = k;
  return tracks;
}

}  // namespace cloud_colorizer::alignment
