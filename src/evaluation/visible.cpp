// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause
#include "evaluation/visible.hpp"

#include <cmath>

#include "base/robust.hpp"
#include "cloud_colorizer/base/check.hpp"
#include "evaluation/clouds.hpp"
#include "evaluation/table.hpp"
#include "surface/kdtree.hpp"

namespace cloud_colorizer {
namespace {

using Eigen::Index;

constexpr double kSpacings = 3;
constexpr Index kSamples = 10000;  // of the map, for its spacing

std::string share(std::size_t part, std::size_t whole) {
  return formatNumber(100 * static_cast<double>(part) / static_cast<double>(whole), 2) + " %";
}

double medianSpacing(const Points& points, const KdTree& tree) {
  std::vector<float> distances;
  const Index step = std::max<Index>(1, points.cols() / kSamples);
  for (Index p = 0; p < points.cols(); p += step) {
    std::uint32_t nearest[2];
    float squared[2];
    tree.nearest(points.col(p), 2, nearest, squared);
    distances.push_back(std::sqrt(squared[1]));
  }
  return static_cast<double>(median(distances));
}

}  // namespace

void VisibleCounts::add(const VisibleCounts& other) {
  views += other.views;
  seen += other.seen;
  in_map += other.in_map;
  colored += other.colored;
}

std::string VisibleCounts::describe() const {
  if (seen == 0) return "nothing was certainly seen";
  std::string text = views > 0 ? std::to_string(views) + " views: " : "";
  text += std::to_string(seen) + " certainly seen";
  if (in_map < seen) text += ", " + share(in_map, seen) + " of them in the map";
  return text + "; coloured " + (in_map == 0 ? "none" : share(colored, in_map));
}

VisibleCounts countSeen(const Cloud& cloud, const std::string& source) {
  const auto field = findField(cloud.fields, "seen");
  require(field.has_value(), source, ": the cloud has no field 'seen' that tells what was seen; give the bag as well");
  const std::vector<std::uint16_t> views = coloredCloud(cloud, source).count;
  const std::size_t size = recordSize(cloud.fields);
  VisibleCounts counts;
  for (std::size_t p = 0; p < views.size(); ++p) {
    if (!(numberAt(cloud.records.data() + p * size + field->offset, field->field.type) > 0)) continue;
    ++counts.seen;
    counts.colored += views[p] > 0 ? 1 : 0;
  }
  counts.in_map = counts.seen;
  return counts;
}

struct VisibleReturns::Impl {
  Impl(const Cloud& map, const std::string& source, double wanted_distance)
      : views(coloredCloud(map, source).count),
        origin(map.positions.cols() > 0 ? Eigen::Vector3d(map.positions.col(0)) : Eigen::Vector3d::Zero()),
        points((map.positions.colwise() - origin).cast<float>()),
        tree(points) {
    require(points.cols() > 1, source, ": the cloud has ", points.cols(), " points, too few to compare with");
    max_distance = wanted_distance > 0 ? wanted_distance : kSpacings * medianSpacing(points, tree);
  }

  std::vector<std::uint16_t> views;
  Eigen::Vector3d origin;  ///< float has half-metre steps at UTM coordinates
  Points points;
  KdTree tree;
  double max_distance = 0;
};

VisibleReturns::VisibleReturns(const Cloud& map, const std::string& source, double max_distance)
    : impl_(std::make_unique<const Impl>(map, source, max_distance)) {}
VisibleReturns::~VisibleReturns() = default;

double VisibleReturns::maxDistance() const {
  return impl_->max_distance;
}

VisibleCounts VisibleReturns::count(const Eigen::Matrix3Xd& returns, const Camera& camera,
                                    const Eigen::Isometry3d& map_from_camera) const {
  VisibleCounts counts;
  counts.views = 1;
  const Eigen::Isometry3d camera_from_map = map_from_camera.inverse();
  const auto right = static_cast<float>(camera.intrinsics().width - 1);
  const auto bottom = static_cast<float>(camera.intrinsics().height - 1);
  for (Index i = 0; i < returns.cols(); ++i) {
    if (!returns.col(i).allFinite()) continue;
    const auto pixel = camera.project((camera_from_map * returns.col(i)).cast<float>());
    if (!pixel || !(pixel->x() >= 0 && pixel->y() >= 0 && pixel->x() <= right && pixel->y() <= bottom)) continue;
    ++counts.seen;
    std::uint32_t nearest = 0;
    float squared = 0;
    impl_->tree.nearest((returns.col(i) - impl_->origin).cast<float>(), 1, &nearest, &squared);
    if (!(squared <= impl_->max_distance * impl_->max_distance)) continue;
    ++counts.in_map;
    counts.colored += impl_->views[nearest] > 0 ? 1 : 0;
  }
  return counts;
}

}  // namespace cloud_colorizer
