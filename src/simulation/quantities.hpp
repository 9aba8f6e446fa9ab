// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause

/// What other cameras than those of colours see of the street: classes and temperatures, with known truth.
#pragma once

#include <opencv2/core.hpp>

#include "simulation/drive.hpp"
#include "simulation/sensors.hpp"

namespace cloud_colorizer::simulation {

constexpr double kThermalScale = 0.01, kThermalOffset = -273.15;  // degrees Celsius of the numbers
constexpr double kThermalNoise = 0.5;                             // degrees, standard deviation of a pixel
constexpr double kMislabelled = 0.15;                             // share of the blocks that a segmentation gets wrong

/// 0: the sky; else one class for each kind of material.
std::uint8_t classOf(const Solid& solid);
constexpr int kNumClasses = 14;

/// Degrees Celsius, smooth over the street.
double temperatureAt(const Eigen::Vector3d& point);

struct QuantityImages {
  cv::Mat1b labels;   ///< classes, in blocks now and then another one
  cv::Mat1w thermal;  ///< numbers
};
/// As the camera sees them beside its image `frame`. One thread.
QuantityImages takeQuantities(const Scene& scene, const Drive& drive, const PixelRays& rays, int camera, int frame);

}  // namespace cloud_colorizer::simulation
