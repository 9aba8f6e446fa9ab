// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause

#include "simulation/city.hpp"

#include <algorithm>
#include <cmath>

#include "base/parallel.hpp"
#include "cloud_colorizer/base/check.hpp"
#include "cloud_colorizer/visibility/depth_image.hpp"
#include "simulation/random.hpp"

namespace cloud_colorizer::simulation {
namespace {

constexpr double kPi = 3.14159265358979;
constexpr double kRange = 60, kNearest = 1;      // m, of the scanner
constexpr double kScoredReach = 40;              // m, from a view to what it is asked for
constexpr double kRangeNoise = 0.003;            // m, standard deviation
constexpr double kGrazingCosine = 0.02;          // below it nothing comes back
constexpr double kToHouses = 8;                  // m, where points are as far apart along the way as along a profile
constexpr std::uint64_t kRaysOfBlock = 1 << 14;  // of a thread; blocks of one call:
constexpr std::uint64_t kBlocks = 32;
constexpr std::uint64_t kTrialRays = 40000;

}  // namespace

Options driveOfCity(const CityOptions& options) {
  requireInRange("points", options.points, std::size_t{1}, std::size_t{100000000000});
  requireInRange("views", options.views, 2, 100000);
  Options drive = presetOptions("clean");
  drive.seed = options.seed;
  drive.cameras = 2;
  drive.frames = (options.views + 1) / 2;
  drive.width = options.width;
  drive.height = options.height;
  drive.pinhole = true;  // photographs are undistorted before they are used, and every program can read these
  drive.check();
  return drive;
}

std::vector<CityView> viewsOfCity(const Drive& drive, int num_views) {
  std::vector<CityView> views;
  views.reserve(static_cast<std::size_t>(num_views));
  for (int v = 0; v < num_views; ++v) views.push_back({v % drive.options().cameras, v / drive.options().cameras});
  return views;
}

struct CityScanner::Point {
  Eigen::Vector3d position{0, 0, 0};
  float intensity = 0;
  std::uint8_t color[3] = {0, 0, 0}, seen = 0, hidden = 0;
};

CityScanner::CityScanner(const Scene& scene, const Drive& drive, const std::vector<CityView>& views,
                         std::size_t num_points, int num_threads)
    : scene_(scene), drive_(drive), num_threads_(num_threads), num_left_(num_points) {
  for (const auto& [camera, frame] : views) views_.push_back(trueView(drive, camera, frame));
  std::stable_sort(views_.begin(), views_.end(), [](const TrueView& a, const TrueView& b) { return a.time < b.time; });
  const double way = drive.options().speed * drive.options().frames / drive.options().rate;
  const double around = 2 * kPi * kToHouses;
  profile_ = {1, kTrialRays};
  const double rays = static_cast<double>(num_points) / shareOfHits();
  const double turns = std::max(1.0, std::round(std::sqrt(rays * way / around)));
  profile_ = {static_cast<std::size_t>(turns), static_cast<std::size_t>(std::max(1.0, std::ceil(rays / turns)))};
}

/// Of some rays all over the way.
double CityScanner::shareOfHits() const {
  std::uint64_t hits = 0;
  Point point;
  for (std::uint64_t ray = 0; ray < kTrialRays; ++ray) hits += castRay(ray * 2654435761U % kTrialRays, point) ? 1 : 0;
  require(hits > 0, "the scanner meets nothing in this street");
  return static_cast<double>(hits) / static_cast<double>(kTrialRays);
}

std::vector<Field> CityScanner::fields() {
  return {{"intensity", FieldType::kFloat32, 1}, {"true_red", FieldType::kUint8, 1},
          {"true_green", FieldType::kUint8, 1},  {"true_blue", FieldType::kUint8, 1},
          {"seen", FieldType::kUint8, 1},        {"hidden", FieldType::kUint8, 1}};
}

Cloud CityScanner::next() {
  std::vector<std::vector<Point>> blocks(kBlocks);
  while (num_left_ > 0 && blocks.front().empty()) {
    parallelFor(num_threads_, kBlocks, [&](std::size_t b) {
      const std::uint64_t begin = next_ray_ + b * kRaysOfBlock;
      blocks[b] = scanRays(begin, begin + kRaysOfBlock);
    });
    next_ray_ += kBlocks * kRaysOfBlock;
  }
  std::size_t count = 0;
  for (const auto& block : blocks) count += block.size();
  count = std::min(count, num_left_);
  num_left_ -= count;
  Cloud cloud{Eigen::Matrix3Xd(3, static_cast<Eigen::Index>(count)), fields(), {}};
  const std::size_t size = recordSize(cloud.fields);
  cloud.records.resize(count * size);
  std::size_t i = 0;
  for (const auto& block : blocks) {
    for (const Point& point : block) {
      if (i == count) break;
      cloud.positions.col(static_cast<Eigen::Index>(i)) = point.position;
      std::uint8_t* const record = cloud.records.data() + size * i++;
      std::memcpy(record, &point.intensity, sizeof(float));
      std::copy(point.color, point.color + 3, record + 4);
      record[7] = point.seen, record[8] = point.hidden;
    }
  }
  return cloud;
}

std::vector<CityScanner::Point> CityScanner::scanRays(std::uint64_t begin, std::uint64_t end) const {
  std::vector<Point> points;
  Point point;
  for (std::uint64_t ray = begin; ray < end; ++ray) {
    if (castRay(ray, point)) points.push_back(point);
  }
  return points;
}

/// Where the whole way was scanned and points are missing, it is scanned again between the profiles.
bool CityScanner::castRay(std::uint64_t ray, Point& point) const {
  const std::uint64_t all = static_cast<std::uint64_t>(profile_.turns) * profile_.rays;
  const std::uint64_t key = keyOf(drive_.options().seed, 60, ray), turn = ray / profile_.rays;
  const double share = (static_cast<double>(ray % all) + (ray < all ? 0 : 0.5)) / static_cast<double>(all);
  const double time = drive_.scanTime(0) + share * drive_.options().frames / drive_.options().rate;
  const double angle = 2 * kPi * (static_cast<double>(ray % profile_.rays) + uniform(keyOf(key, 1))) /
                       static_cast<double>(profile_.rays);
  const double yaw = (turn % 2 == 0 ? 0.25 : -0.25) * kPi;
  const Eigen::Isometry3d map_from_lidar = drive_.mapFromBase(time) * drive_.baseFromLidar();
  const Eigen::Vector3d direction =
      map_from_lidar.linear() *
      Eigen::Vector3d(-std::sin(yaw) * std::cos(angle), std::cos(yaw) * std::cos(angle), std::sin(angle));
  const Eigen::Vector3d origin = map_from_lidar.translation();
  const auto hit = scene_.castRay(origin, direction, time, kRange);
  if (!hit || hit->distance < kNearest || -hit->normal.dot(direction) < kGrazingCosine) return false;
  point = {};
  point.position = origin + (hit->distance + kRangeNoise * gaussian(keyOf(key, 2))) * direction;
  const Color color = scene_.trueColor(*hit);
  for (int c = 0; c < 3; ++c) point.color[c] = static_cast<std::uint8_t>(std::lround(std::clamp(color[c], 0.F, 255.F)));
  point.intensity = color.mean();
  lookFromViews(*hit, time, point);
  return true;
}

/// Those of the moment first, for one free line of sight is enough.
void CityScanner::lookFromViews(const Hit& hit, double time, Point& point) const {
  const auto sees = [&](const TrueView& view) {
    const LineOfSight sight = lineOfSight(scene_, hit, view, kScoredReach);
    if (sight != LineOfSight::kOutOfView) point.hidden = 1;
    return sight == LineOfSight::kFree;
  };
  auto later = std::lower_bound(views_.begin(), views_.end(), time,
                                [](const TrueView& view, double t) { return view.time < t; });
  auto earlier = later;
  while (point.seen == 0 && (earlier != views_.begin() || later != views_.end())) {
    if (earlier != views_.begin() && sees(*--earlier)) point.seen = 1;
    if (point.seen == 0 && later != views_.end() && sees(*later++)) point.seen = 1;
  }
  if (point.seen == 1) point.hidden = 0;
}

}  // namespace cloud_colorizer::simulation
