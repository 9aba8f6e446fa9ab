// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause

/// CIE L*a*b* and the CIEDE2000 difference, with the names of Sharma, Wu and Dalal, "The CIEDE2000 color-difference
/// formula", Color Research and Application 30(1), 2005.
#include <algorithm>
#include <cmath>

#include "evaluation/score.hpp"

namespace cloud_colorizer {
namespace {

constexpr double kRadians = 3.14159265358979323846 / 180;

double linearFromSrgb(double value) {
  const double s = std::clamp(value / 255, 0.0, 1.0);
  return s <= 0.04045 ? s / 12.92 : std::pow((s + 0.055) / 1.055, 2.4);
}

double labFunction(double t) {
  return t > 216.0 / 24389 ? std::cbrt(t) : (24389.0 / 27 * t + 16) / 116;
}

/// Hue angle in [0, 360), 0 for grey.
double hueOf(double a, double b) {
  if (a == 0 && b == 0) return 0;
  const double angle = std::atan2(b, a) / kRadians;
  return angle < 0 ? angle + 360 : angle;
}

double pow7(double x) {
  return std::pow(x, 7);
}

/// The share by which a* is stretched or shrunk near grey, and again in the rotation term.
double chromaRatio(double chroma) {
  return std::sqrt(pow7(chroma) / (pow7(chroma) + pow7(25)));
}

double hueDifference(double h1, double h2, bool grey) {
  if (grey) return 0;
  const double d = h2 - h1;
  if (d > 180) return d - 360;
  return d < -180 ? d + 360 : d;
}

double meanHue(double h1, double h2, bool grey) {
  if (grey) return h1 + h2;
  if (std::abs(h1 - h2) <= 180) return (h1 + h2) / 2;
  return h1 + h2 < 360 ? (h1 + h2 + 360) / 2 : (h1 + h2 - 360) / 2;
}

}  // namespace

Eigen::Vector3d labFromRgb(const Eigen::Vector3d& rgb) {
  const double r = linearFromSrgb(rgb[0]), g = linearFromSrgb(rgb[1]), b = linearFromSrgb(rgb[2]);
  const double x = labFunction((0.4124564 * r + 0.3575761 * g + 0.1804375 * b) / 0.95047);
  const double y = labFunction(0.2126729 * r + 0.7151522 * g + 0.0721750 * b);
  const double z = labFunction((0.0193339 * r + 0.1191920 * g + 0.9503041 * b) / 1.08883);
  return {116 * y - 16, 500 * (x - y), 200 * (y - z)};
}

double ciede2000(const Eigen::Vector3d& lab1, const Eigen::Vector3d& lab2) {
  const double mean_chroma = (std::hypot(lab1[1], lab1[2]) + std::hypot(lab2[1], lab2[2])) / 2;
  const double stretch = 1 + 0.5 * (1 - chromaRatio(mean_chroma));
  const double a1 = stretch * lab1[1], a2 = stretch * lab2[1];
  const double c1 = std::hypot(a1, lab1[2]), c2 = std::hypot(a2, lab2[2]);
  const double h1 = hueOf(a1, lab1[2]), h2 = hueOf(a2, lab2[2]);
  const bool grey = c1 * c2 == 0;
  const double delta_l = lab2[0] - lab1[0], delta_c = c2 - c1;
  const double delta_h = 2 * std::sqrt(c1 * c2) * std::sin(hueDifference(h1, h2, grey) / 2 * kRadians);
  const double l = (lab1[0] + lab2[0]) / 2, c = (c1 + c2) / 2, h = meanHue(h1, h2, grey);
  const double t = 1 - 0.17 * std::cos((h - 30) * kRadians) + 0.24 * std::cos(2 * h * kRadians) +
                   0.32 * std::cos((3 * h + 6) * kRadians) - 0.20 * std::cos((4 * h - 63) * kRadians);
  const double delta_theta = 30 * std::exp(-std::pow((h - 275) / 25, 2));
  const double s_l = 1 + 0.015 * std::pow(l - 50, 2) / std::sqrt(20 + std::pow(l - 50, 2));
  const double s_c = 1 + 0.045 * c, s_h = 1 + 0.015 * c * t;
  const double r_t = -std::sin(2 * delta_theta * kRadians) * 2 * chromaRatio(c);
  const double dl = delta_l / s_l, dc = delta_c / s_c, dh = delta_h / s_h;
  return std::sqrt(std::max(0.0, dl * dl + dc * dc + dh * dh + r_t * dc * dh));
}

}  // namespace cloud_colorizer
