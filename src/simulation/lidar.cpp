// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause

#include <algorithm>
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

}  // namespace

std::vector<Return> takeScan(const Scene& scene, const Drive& drive, int frame) {
  constexpr double kNearest = 0.8;         // m
  constexpr double kGrazingCosine = 0.01;  // below it nothing comes back
  const Options& o = drive.options();
  const double start = drive.scanTime(frame);
  const Eigen::Isometry3d lidar_from_map = (drive.mapFromBase(start) * drive.baseFromLidar()).inverse();
  std::vector<Return> returns;
  returns.reserve(static_cast<std::size_t>(o.beams) * static_cast<std::size_t>(o.azimuths));
  for (int azimuth = 0; azimuth < o.azimuths; ++azimuth) {
    const double share = static_cast<double>(azimuth) / o.azimuths;
    const double time = share / o.rate;
    const Eigen::Isometry3d map_from_lidar = drive.mapFromBase(start + time) * drive.baseFromLidar();
    for (int beam = 0; beam < o.beams; ++beam) {
      const std::uint64_t key = keyOf(o.seed, 50, frame, azimuth, beam);
      const double up = o.beams > 1 ? kLowest + (kHighest - kLowest) * beam / (o.beams - 1) : 0;
      const double around = -2 * kPi * share + 0.2 / o.azimuths * (beam % 4);
      const Eigen::Vector3d direction =
          map_from_lidar.linear() *
          Eigen::Vector3d(std::cos(up) * std::cos(around), std::cos(up) * std::sin(around), std::sin(up));
      const auto hit = scene.castRay(map_from_lidar.translation(), direction, start + time, o.lidar_range);
      if (!hit || hit->distance < kNearest) continue;
      const double cosine = -hit->normal.dot(direction);
      if (cosine < kGrazingCosine) continue;
      Return r;
      const Eigen::Vector3d measured = hit->point + o.range_noise * gaussian(keyOf(key, 1)) * direction;
      r.point = (lidar_from_map * measured).cast<float>();
      r.intensity = intensityOf(scene, *hit, cosine, keyOf(key, 2));
      r.ring = static_cast<std::uint16_t>(beam);
      r.time = static_cast<float>(time);
      r.truth = *hit;
      returns.push_back(r);
    }
  }
  return returns;
}

}  // namespace cloud_colorizer::simulation
