// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause
#include "simulation/quantities.hpp"

#include <cmath>

#include "simulation/random.hpp"

namespace cloud_colorizer::simulation {
namespace {

constexpr int kBlock = 24;  // px, of what a segmentation gets wrong at once
constexpr double kSkyTemperature = -20;

/// Wrong in blocks, as segmentations are; every image has others.
std::uint8_t segmented(std::uint8_t truth, std::uint64_t image, int u, int v) {
  const std::uint64_t block = keyOf(image, u / kBlock, v / kBlock);
  if (uniform(block) >= kMislabelled) return truth;
  return static_cast<std::uint8_t>(1 + static_cast<int>(uniform(~block) * (kNumClasses - 1)));
}

std::uint16_t numberOf(double temperature, std::uint64_t image, int u, int v) {
  const double noisy = temperature + kThermalNoise * gaussian(keyOf(image, u, v));
  return cv::saturate_cast<std::uint16_t>((noisy - kThermalOffset) / kThermalScale);
}

}  // namespace

std::uint8_t classOf(const Solid& solid) {
  return static_cast<std::uint8_t>(1 + static_cast<int>(solid.primitive().material.pattern));
}

double temperatureAt(const Eigen::Vector3d& point) {
  return 18 + 6 * std::sin(0.35 * point.x()) * std::cos(0.25 * point.y()) + 0.8 * point.z();
}

QuantityImages takeQuantities(const Scene& scene, const Drive& drive, const PixelRays& rays, int camera, int frame) {
  const double time = drive.imageTime(camera, frame);
  const int seed = drive.options().seed;
  const std::uint64_t labels_key = keyOf(seed, 61, camera, frame), thermal_key = keyOf(seed, 62, camera, frame);
  QuantityImages images{cv::Mat1b(rays.height(), rays.width()), cv::Mat1w(rays.height(), rays.width())};
  for (int v = 0; v < rays.height(); ++v) {
    const Eigen::Isometry3d pose = drive.mapFromCamera(camera, frame, (v + 0.5) / rays.height());
    for (int u = 0; u < rays.width(); ++u) {
      const Eigen::Vector3f bearing = rays.bearing(u, v);
      const auto hit = bearing.isZero() ? std::nullopt
                                        : scene.castRay(pose.translation(),
                                                        (pose.linear() * bearing.cast<double>()).normalized(), time);
      const std::uint8_t truth = hit ? classOf(scene.solids()[static_cast<std::size_t>(hit->solid)]) : std::uint8_t{0};
      images.labels(v, u) = segmented(truth, labels_key, u, v);
      images.thermal(v, u) = numberOf(hit ? temperatureAt(hit->point) : kSkyTemperature, thermal_key, u, v);
    }
  }
  return images;
}

}  // namespace cloud_colorizer::simulation
