// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause

/// Scenes of rectangles, boxes and upright cylinders with exact ray casting: the oracle for what a view sees.
#pragma once

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <random>
#include <unordered_set>
#include <vector>

#include "cloud_colorizer/base/types.hpp"
#include "cloud_colorizer/camera/camera.hpp"

namespace cloud_colorizer::test {

struct Box {  // a rectangle is a flat box
  Eigen::Vector3d low, high;
};
struct Cylinder {
  Eigen::Vector2d center;
  double radius, low, high;
};

struct Scene {
  std::vector<Box> boxes;
  std::vector<Cylinder> cylinders;

  /// Distance along the unit ray to the first surface; infinity when there is none.
  double cast(const Eigen::Vector3d& from, const Eigen::Vector3d& ray) const {
    double nearest = std::numeric_limits<double>::infinity();
    for (const Box& box : boxes) nearest = std::min(nearest, castBox(box, from, ray));
    for (const Cylinder& cylinder : cylinders) nearest = std::min(nearest, castCylinder(cylinder, from, ray));
    return nearest;
  }
  /// Is there a free line of sight between a place and a point on a surface?
  bool sees(const Eigen::Vector3d& from, const Eigen::Vector3d& point) const {
    const double distance = (point - from).norm();
    return cast(from, (point - from) / distance) > distance - 0.005;
  }

 private:
  static double castBox(const Box& box, const Eigen::Vector3d& from, const Eigen::Vector3d& ray) {
    double enter = -std::numeric_limits<double>::infinity(), leave = -enter;
    for (int a = 0; a < 3; ++a) {
      if (std::abs(ray[a]) < 1e-12) {
        if (from[a] < box.low[a] || from[a] > box.high[a]) return std::numeric_limits<double>::infinity();
        continue;
      }
      const double s = (box.low[a] - from[a]) / ray[a], t = (box.high[a] - from[a]) / ray[a];
      enter = std::max(enter, std::min(s, t)), leave = std::min(leave, std::max(s, t));
    }
    return enter > 1e-6 && enter <= leave ? enter : std::numeric_limits<double>::infinity();
  }
  static double castCylinder(const Cylinder& c, const Eigen::Vector3d& from, const Eigen::Vector3d& ray) {
    const Eigen::Vector2d o = from.head<2>() - c.center, d = ray.head<2>();
    const double a = d.squaredNorm(), b = o.dot(d), root = b * b - a * (o.squaredNorm() - c.radius * c.radius);
    if (a < 1e-12 || root < 0) return std::numeric_limits<double>::infinity();
    const double t = (-b - std::sqrt(root)) / a, z = from.z() + t * ray.z();
    return t > 1e-6 && z >= c.low && z <= c.high ? t : std::numeric_limits<double>::infinity();
  }
};

/// Points as measured, and where each truly lies on its surface.
struct Scan {
  Points points;
  std::vector<Eigen::Vector3d> truth;
};

/// Keeps the first point of every voxel.
class Thinner {
 public:
  explicit Thinner(double voxel) : voxel_(voxel) {}
  void add(const Eigen::Vector3d& measured, const Eigen::Vector3d& truth) {
    const Eigen::Matrix<std::int64_t, 3, 1> cell = (measured / voxel_).array().floor().cast<std::int64_t>();
    if (!cells_.insert((cell.x() * 2000003 + cell.y()) * 2000003 + cell.z()).second) return;
    measured_.push_back(measured.cast<float>());
    truth_.push_back(truth);
  }
  Scan finish() const {
    Scan scan{Points(3, static_cast<Eigen::Index>(measured_.size())), truth_};
    for (std::size_t i = 0; i < measured_.size(); ++i) scan.points.col(static_cast<Eigen::Index>(i)) = measured_[i];
    return scan;
  }

 private:
  double voxel_;
  std::unordered_set<std::int64_t> cells_;
  std::vector<Eigen::Vector3f> measured_;
  std::vector<Eigen::Vector3d> truth_;
};

struct Lidar {
  int beams = 48, columns = 1200;
  double lowest = -25, highest = 15;  // deg
  double range_noise = 0.02;          // m
  double pose_noise = 0.01;           // m an axis and sweep
  double pose_turn = 0.05;            // deg about the vertical and sweep
  double range = 60;                  // m
};

/// One sweep from each place, thinned to one point a voxel.
inline Scan sweep(const Scene& scene, const std::vector<Eigen::Vector3d>& places, const Lidar& lidar, double voxel,
                  unsigned seed) {
  constexpr double kDegree = 3.14159265358979323846 / 180;
  std::mt19937 random(seed);
  std::normal_distribution<double> normal;
  Thinner thinner(voxel);
  for (const auto& place : places) {
    const Eigen::Vector3d shift = lidar.pose_noise * Eigen::Vector3d(normal(random), normal(random), normal(random));
    const Eigen::AngleAxisd turn(lidar.pose_turn * kDegree * normal(random), Eigen::Vector3d::UnitZ());
    for (int i = 0; i < lidar.beams * lidar.columns; ++i) {
      const double azimuth = 360 * kDegree * (i / lidar.beams) / lidar.columns;
      const double elevation =
          kDegree * (lidar.lowest + (lidar.highest - lidar.lowest) * (i % lidar.beams) / (lidar.beams - 1));
      const Eigen::Vector3d ray(std::cos(elevation) * std::cos(azimuth), std::cos(elevation) * std::sin(azimuth),
                                std::sin(elevation));
      const double hit = scene.cast(place, ray);
      if (!(hit < lidar.range)) continue;
      const Eigen::Vector3d measured = turn * (ray * (hit + lidar.range_noise * normal(random))) + place + shift;
      thinner.add(measured, place + hit * ray);
    }
  }
  return thinner.finish();
}

/// Camera pose: at a place (z up), looking at a heading and pitch [deg].
inline Eigen::Isometry3d lookAlong(const Eigen::Vector3d& place, double heading, double pitch = 0) {
  constexpr double kDegree = 3.14159265358979323846 / 180;
  Eigen::Matrix3d map_from_optical;
  map_from_optical << 0, 0, 1, -1, 0, 0, 0, -1, 0;  // z forward to x, x right to -y, y down to -z
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
  pose.translation() = place;
  pose.linear() = Eigen::AngleAxisd(heading * kDegree, Eigen::Vector3d::UnitZ()) *
                  Eigen::AngleAxisd(pitch * kDegree, Eigen::Vector3d::UnitY()) * map_from_optical;
  return pose;
}

/// A street along x: ground, two facades with recesses, poles of 5 cm radius, parked cars.
inline Scene makeStreet() {
  Scene scene;
  scene.boxes.push_back({{-40, -30, -0.5}, {90, 30, 0}});
  for (int i = 0; i < 9; ++i) {  // houses with gaps, and bays that stand out
    const double x = -30 + 12 * i;
    scene.boxes.push_back({{x, 9, 0}, {x + 10, 15, 9}});
    scene.boxes.push_back({{x + 3, 8.4, 0.8}, {x + 6, 9, 6}});
    scene.boxes.push_back({{x, -17, 0}, {x + 10, -11, 8}});
  }
  for (int i = 0; i < 8; ++i) {
    const double x = -15 + 10.5 * i;
    scene.cylinders.push_back({{x, 6}, 0.05, 0, 5});
    scene.cylinders.push_back({{x + 4, -8}, 0.05, 0, 5});
    scene.boxes.push_back({{x + 1, 3.4, 0.25}, {x + 5.2, 5.2, 0.9}});
    scene.boxes.push_back({{x + 2, 3.5, 0.9}, {x + 4.4, 5.1, 1.45}});
    scene.boxes.push_back({{x, -6.6, 0}, {x + 4.2, -4.8, 1.5}});
  }
  return scene;
}

}  // namespace cloud_colorizer::test
