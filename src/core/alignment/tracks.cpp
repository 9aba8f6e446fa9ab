// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause
#include "alignment/tracks.hpp"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

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

void keepByPriority(std::vector<Sight>& sights, std::size_t max_points) {
  if (sights.size() <= max_points) return;
  const auto before = [](const Sight& a, const Sight& b) { return priority(a.point) < priority(b.point); };
  std::nth_element(sights.begin(), sights.begin() + static_cast<std::ptrdiff_t>(max_points), sights.end(), before);
  sights.resize(max_points);
  std::sort(sights.begin(), sights.end(), [](const auto& a, const auto& b) { return a.point < b.point; });
}

// Looks from one view at points.
class Finder {
 public:
  Finder(const AlignmentInput& input, const Camera& camera, const DepthImage& depth,
         const Eigen::Isometry3d& map_from_camera)
      : input_(input),
        camera_(camera),
        depth_(depth),
        edge_distance_(distanceToEdges(depth)),
        camera_from_map_(map_from_camera.inverse().cast<float>()),
        max_distance_(static_cast<float>(input.depth_params.reach())) {}

  void find(const PointRun& run, std::vector<Sight>& sights) const {
    const Eigen::Vector3f center = camera_from_map_ * run.center;
    if (!camera_.mayShow(center, run.radius) || center.norm() > max_distance_ + run.radius) return;
    for (Eigen::Index p = run.begin; p < run.end; ++p) {
      Sight sight{static_cast<std::uint32_t>(p), 0, 0};
      if (see(p, sight)) sights.push_back(sight);
    }
  }

 private:
  bool see(Eigen::Index p, Sight& sight) const {
    const Eigen::Vector3f local = camera_from_map_ * input_.points.col(p);
    if (local.norm() > max_distance_ || input_.surfels.radii[p] < 0) return false;
    const auto pixel = camera_.project(local);
    if (!pixel) return false;
    const Eigen::Vector3f normal = camera_from_map_.linear() * input_.surfels.normals.col(p);
    sight.weight = incidence(normal, local);
    if (sight.weight < kGrazing) return false;
    const auto visibility =
        depth_.test(*pixel, local, normal, input_.surfels.radii[p], input_.depth_params, input_.surfels.thickness(p));
    if (visibility != Visibility::kVisible) return false;
    const auto cellOf = [&](float at, int count) {
      return std::clamp(static_cast<int>((at + 0.5F) / depth_.cell_size), 0, count - 1);
    };
    const float to_edge =
        edge_distance_(cellOf(pixel->y(), edge_distance_.rows), cellOf(pixel->x(), edge_distance_.cols));
    sight.edge_distance = std::min(to_edge, distanceToBorder(*pixel, camera_.intrinsics()));
    return true;
  }

  const AlignmentInput& input_;
  const Camera& camera_;
  const DepthImage& depth_;
  cv::Mat1f edge_distance_;
  Eigen::Isometry3f camera_from_map_;
  float max_distance_;
};

}  // namespace

std::vector<Sight> findSights(const AlignmentInput& input, const std::vector<PointRun>& runs, std::size_t view,
                              const Eigen::Isometry3d& map_from_camera, std::size_t max_points) {
  std::vector<Sight> sights;
  const auto depth = input.depth(view, map_from_camera);
  if (!depth || depth->depth.empty()) return sights;
  const Camera camera = input.cameraOf(view);
  const Finder finder(input, camera, *depth, map_from_camera);
  for (const PointRun& run : runs) finder.find(run, sights);
  keepByPriority(sights, max_points);
  return sights;
}

std::vector<Sight> seenInBoth(const std::vector<Sight>& a, const std::vector<Sight>& b) {
  std::vector<Sight> both;
  for (auto i = a.begin(), j = b.begin(); i != a.end() && j != b.end();) {
    if (i->point == j->point) {
      both.push_back({i->point, i->weight, std::min(i->edge_distance, j->edge_distance)});
      ++i, ++j;
    } else if (i->point < j->point) {
      ++i;
    } else {
      ++j;
    }
  }
  return both;
}

Tracks makeTracks(const std::vector<std::vector<Sight>>& by_view, std::size_t num_points, std::size_t max_points,
                  const std::function<bool(std::uint32_t)>& keep) {
  Tracks tracks;
  tracks.offsets.push_back(0);
  tracks.point_offsets.assign(num_points + 1, 0);
  std::vector<Sight> kept;
  for (std::size_t v = 0; v < by_view.size(); ++v) {
    kept = by_view[v];
    keepByPriority(kept, max_points);
    const auto leave = [&](const Sight& sight) { return keep && !keep(sight.point); };
    kept.erase(std::remove_if(kept.begin(), kept.end(), leave), kept.end());
    tracks.sights.insert(tracks.sights.end(), kept.begin(), kept.end());
    tracks.views.insert(tracks.views.end(), kept.size(), static_cast<std::uint32_t>(v));
    tracks.offsets.push_back(static_cast<std::uint32_t>(tracks.sights.size()));
    for (const Sight& sight : kept) ++tracks.point_offsets[sight.point + 1];
  }
  for (std::size_t p = 0; p < num_points; ++p) tracks.point_offsets[p + 1] += tracks.point_offsets[p];
  std::vector<std::uint32_t> next(tracks.point_offsets.begin(), tracks.point_offsets.end() - 1);
  tracks.by_point.resize(tracks.sights.size());
  for (std::uint32_t k = 0; k < tracks.sights.size(); ++k) tracks.by_point[next[tracks.sights[k].point]++] = k;
  return tracks;
}

}  // namespace cloud_colorizer::alignment
