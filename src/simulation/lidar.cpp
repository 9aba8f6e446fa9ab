// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause

#include <algorithm>
#include <array>
#include <cmath>

#include "simulation/random.hpp"
#include "simulation/sensors.hpp"

namespace cloud_colorizer::simulation {
namespace {

constexpr double kPi = 3.14159265358979;
constexpr double kLowest = -25 * kPi / 180;
constexpr double kHighest = 18 * kPi / 180;

/// Strong for bright and reflecting surfaces that face the sensor.
float intensityOf(const Scene& scene, const Hit& hit, double cosine, std::uint64_t key) {
  const Material& material = scene.solids()[static_cast<std::size_t>(hit.solid)].primitive().material;
  const float grey = scene.trueColor(hit).mean() / 255;
  const double strength = 0.65 * static_cast<double>(grey) + 0.35 * static_cast<double>(material.reflectivity);
  const double value = 255 * strength * (0.55 + 0.45 * cosine) + 3 * gaussian(key);
  return static_cast<float>(std::clamp(value, 0.0, 255.0));
}

/// Sends beams and tells what comes back. Of rays that fill it, those that end within the length of a pulse are one
/// return.
class Sender {
 public:
  Sender(const Scene& scene, const Options& options, const Eigen::Vector3d& origin, double time)
      : scene_(scene), options_(options), origin_(origin), time_(time) {}

  struct Echo {
    Hit hit;
    double range;  ///< m
  };

  std::optional<Echo> send(const Eigen::Vector3d& direction, std::uint64_t key) const {
    if (options_.beam_divergence == 0) {
      const auto hit = cast(direction);
      if (!hit) return {};
      return Echo{*hit, hit->distance};
    }
    const double deviation = 0.25e-3 * options_.beam_divergence;  // a Gaussian's width at 1 / e^2 is four of them
    std::array<std::optional<Hit>, 3> hits;
    const Hit* nearest = nullptr;
    for (std::size_t i = 0; i < hits.size(); ++i) {
      const Eigen::Vector3d aside(gaussian(keyOf(key, i, 0)), gaussian(keyOf(key, i, 1)), gaussian(keyOf(key, i, 2)));
      hits[i] = cast((direction + deviation * (aside - aside.dot(direction) * direction)).normalized());
      if (hits[i] && (nearest == nullptr || hits[i]->distance < nearest->distance)) nearest = &*hits[i];
    }
    if (nearest == nullptr) return {};
    double sum = 0, count = 0;
    for (const auto& hit : hits) {
      if (!hit || hit->distance > nearest->distance + kPulse) continue;
      sum += hit->distance;
      count += 1;
    }
    return Echo{*nearest, sum / count};
  }

 private:
  static constexpr double kPulse = 0.6;  // m

  std::optional<Hit> cast(const Eigen::Vector3d& direction) const {
    constexpr double kNearest = 0.8;         // m
    constexpr double kGrazingCosine = 0.01;  // below it nothing comes back
    auto hit = scene_.castRay(origin_, direction, time_, options_.lidar_range);
    if (hit && (hit->distance < kNearest || -hit->normal.dot(direction) < kGrazingCosine)) return {};
    return hit;
  }

  const Scene& scene_;
  const Options& options_;
  Eigen::Vector3d origin_;
  double time_;
};

}  // namespace

std::vector<Return> takeScan(const Scene& scene, const Drive& drive, int frame) {
  const Options& o = drive.options();
  const double start = drive.scanTime(frame);
  const Eigen::Isometry3d lidar_from_map = (drive.mapFromBase(start) * drive.baseFromLidar()).inverse();
  std::vector<Return> returns;
  returns.reserve(static_cast<std::size_t>(o.beams) * static_cast<std::size_t>(o.azimuths));
  for (int azimuth = 0; azimuth < o.azimuths; ++azimuth) {
    const double share = static_cast<double>(azimuth) / o.azimuths;
    const double time = share / o.rate;
    const Eigen::Isometry3d map_from_lidar = drive.mapFromBase(start + time) * drive.baseFromLidar();
    const Sender sender(scene, o, map_from_lidar.translation(), start + time);
    for (int beam = 0; beam < o.beams; ++beam) {
      const std::uint64_t key = keyOf(o.seed, 50, frame, azimuth, beam);
      const double up = o.beams > 1 ? kLowest + (kHighest - kLowest) * beam / (o.beams - 1) : 0;
      const double around = -2 * kPi * share + 0.2 / o.azimuths * (beam % 4);
      const Eigen::Vector3d direction =
          map_from_lidar.linear() *
          Eigen::Vector3d(std::cos(up) * std::cos(around), std::cos(up) * std::sin(around), std::sin(up));
      const auto echo = sender.send(direction, keyOf(key, 3));
      if (!echo) continue;
      Return r;
      const Eigen::Vector3d measured =
          map_from_lidar.translation() + (echo->range + o.range_noise * gaussian(keyOf(key, 1))) * direction;
      r.point = ((o.skewed ? map_from_lidar.inverse() : lidar_from_map) * measured).cast<float>();
      r.intensity = intensityOf(scene, echo->hit, -echo->hit.normal.dot(direction), keyOf(key, 2));
      r.ring = static_cast<std::uint16_t>(beam);
      r.time = static_cast<float>(time);
      r.truth = echo->hit;
      returns.push_back(r);
    }
  }
  return returns;
}

}  // namespace cloud_colorizer::simulation
