// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause

/// The street as a surveying vehicle has it: a dense scan of any number of points, and large photographs.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "cloud_colorizer/cloud/cloud.hpp"
#include "simulation/drive.hpp"
#include "simulation/scene.hpp"
#include "simulation/truth.hpp"

namespace cloud_colorizer::simulation {

struct CityOptions {
  std::size_t points = 1000000;
  int views = 120;                  ///< of two cameras
  int width = 3000, height = 2000;  ///< px
  int seed = 1;
};

/// The drive that takes the photographs: two a metre. Throws std::invalid_argument with name, value and range.
Options driveOfCity(const CityOptions& options);

struct CityView {
  int camera, frame;
};
/// The first so many of the drive, as its cameras take turns.
std::vector<CityView> viewsOfCity(const Drive& drive, int num_views);

/// Two scanners whose profiles stand at 45 degrees across the way, and turn so fast that points on the houses are about
/// as far apart along the way as along a profile. Points come in the order in which they are scanned.
class CityScanner {
 public:
  CityScanner(const Scene& scene, const Drive& drive, const std::vector<CityView>& views, std::size_t num_points,
              int num_threads);

  /// intensity; true_red, true_green, true_blue; seen: a free line of sight to some view; hidden: in some view's image,
  /// but none sees it. Of points more than 40 m away from all both are 0.
  static std::vector<Field> fields();

  /// The next points (map frame, m; with range noise), as many as a block of rays has; empty at the end.
  Cloud next();

 private:
  struct Point;
  struct Profile {
    std::size_t turns, rays;  ///< rays of a turn
  };

  std::vector<Point> scanRays(std::uint64_t begin, std::uint64_t end) const;
  bool castRay(std::uint64_t ray, Point& point) const;
  void lookFromViews(const Hit& hit, double time, Point& point) const;
  double shareOfHits() const;

  const Scene& scene_;
  const Drive& drive_;
  int num_threads_;
  std::size_t num_left_;
  std::vector<TrueView> views_;  ///< ascending by time
  Profile profile_{1, 1};
  std::uint64_t next_ray_ = 0;
};

}  // namespace cloud_colorizer::simulation
