// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause

/// A small scene for the tests of the alignment: a textured relief z = h(x, y) seen from above, rendered by following
/// each pixel's ray to the surface. Everything about it is known exactly.
#pragma once

#include <cmath>
#include <memory>
#include <random>
#include <vector>

#include "cloud_colorizer/alignment/align.hpp"

namespace cloud_colorizer::test {

struct Relief {
  int width = 160, height = 120;
  double focal = 150;
  double contrast = 50;  ///< grey levels of the texture
  double darkening = 0;  ///< share of the brightness lost at the left and right ends, by the square of the radius

  Intrinsics intrinsics() const {
    Intrinsics k;
    k.width = width;
    k.height = height;
    k.fx = k.fy = focal;
    k.cx = (width - 1) / 2.0;
    k.cy = (height - 1) / 2.0;
    return k;
  }

  static double heightAt(double x, double y) {
    return 0.25 * std::sin(1.7 * x) * std::cos(1.3 * y) + 0.1 * std::sin(3 * y);
  }

  Eigen::Vector3d colorAt(double x, double y) const {
    const double a = std::sin(9 * x + 2 * std::sin(3 * y)) * std::sin(8 * y + 1.5 * std::cos(4 * x));
    const double b = std::sin(15 * x + 7 * y), c = std::cos(3 * x - 4 * y);
    return Eigen::Vector3d(110, 120, 100) +
           contrast * Eigen::Vector3d(0.7 * a + 0.3 * b, 0.6 * a + 0.4 * c, 0.5 * a - 0.3 * b + 0.2 * c);
  }

  Eigen::Vector3d bearing(double u, double v) const {
    return {(u - (width - 1) / 2.0) / focal, (v - (height - 1) / 2.0) / focal, 1};
  }

  /// Where the ray of a pixel meets the relief, by fixed-point iteration on its height.
  Eigen::Vector3d hit(const Eigen::Isometry3d& map_from_camera, const Eigen::Vector3d& bearing) const {
    const Eigen::Vector3d start = map_from_camera.translation(), ray = map_from_camera.linear() * bearing;
    Eigen::Vector3d point = start;
    double z = 0;
    for (int i = 0; i < 7; ++i) {
      point = start + ray * ((z - start.z()) / ray.z());
      z = heightAt(point.x(), point.y());
    }
    return point;
  }

  cv::Mat render(const Eigen::Isometry3d& map_from_camera, double gain, double noise, unsigned seed) const {
    std::mt19937 random(seed);
    std::normal_distribution<double> normal;
    cv::Mat3b image(height, width);
    for (int v = 0; v < height; ++v) {
      for (int u = 0; u < width; ++u) {
        const Eigen::Vector3d point = hit(map_from_camera, bearing(u, v));
        const double x = (u - (width - 1) / 2.0) / (width / 2.0), y = (v - (height - 1) / 2.0) / (width / 2.0);
        const Eigen::Vector3d color = gain * (1 - darkening * (x * x + y * y)) * colorAt(point.x(), point.y());
        for (int c = 0; c < 3; ++c) image(v, u)[c] = cv::saturate_cast<std::uint8_t>(color[c] + noise * normal(random));
      }
    }
    return image;
  }

  /// Looks down from above, a little tilted.
  static Eigen::Isometry3d poseAbove(double x, double y, double tilt_x, double tilt_y) {
    Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
    pose.linear() = Eigen::Vector3d(1, -1, -1).asDiagonal() * (Eigen::AngleAxisd(tilt_x, Eigen::Vector3d::UnitX()) *
                                                               Eigen::AngleAxisd(tilt_y, Eigen::Vector3d::UnitY()))
                                                                  .toRotationMatrix();
    pose.translation() = Eigen::Vector3d(x, y, 3);
    return pose;
  }

  static std::vector<Eigen::Isometry3d> posesAround(int count) {
    std::vector<Eigen::Isometry3d> poses;
    for (int i = 0; i < count; ++i) {
      const double angle = 2 * M_PI * i / count;
      poses.push_back(
          poseAbove(0.6 * std::cos(angle), 0.6 * std::sin(angle), 0.15 * std::sin(angle), -0.15 * std::cos(angle)));
    }
    return poses;
  }
};

/// A relief with views of it, ready to be aligned; `images` may be replaced before input() is called.
struct ReliefViews {
  Relief relief;
  std::vector<Eigen::Isometry3d> true_poses, poses;
  std::vector<double> stamps, gains;
  std::vector<cv::Mat> images;
  int num_points = 4000;

  explicit ReliefViews(int count) : true_poses(Relief::posesAround(count)), poses(true_poses), gains(poses.size(), 1) {}

  void disturbPoses(double rotation_deg, double translation, unsigned seed) {
    std::mt19937 random(seed);
    std::normal_distribution<double> normal;
    const double rotation = rotation_deg * M_PI / 180;
    for (Eigen::Isometry3d& pose : poses) {
      const Eigen::Vector3d axis = rotation * Eigen::Vector3d(normal(random), normal(random), normal(random));
      const Eigen::Vector3d shift = translation * Eigen::Vector3d(normal(random), normal(random), normal(random));
      pose.rotate(Eigen::AngleAxisd(axis.norm(), axis.normalized()));
      pose.translation() += shift;
    }
  }

  void render(double noise) {
    images.clear();
    for (std::size_t v = 0; v < true_poses.size(); ++v) {
      images.push_back(relief.render(true_poses[v], gains[v], noise, static_cast<unsigned>(v)));
    }
  }

  AlignmentInput input() const {
    AlignmentInput input;
    input.cameras.emplace_back(relief.intrinsics());
    for (std::size_t v = 0; v < poses.size(); ++v) {
      View view;
      view.map_from_camera = poses[v];
      view.stamp = v < stamps.size() ? stamps[v] : 0;
      input.views.push_back(view);
    }
    input.images = [this](std::size_t v) { return std::make_shared<const cv::Mat>(images[v]); };
    input.depth = [this](std::size_t, const Eigen::Isometry3d& pose) { return depthImage(pose); };
    addPoints(input);
    return input;
  }

  /// Mean over views and points of the distance between projections with two sets of poses, px.
  double meanError(const std::vector<Eigen::Isometry3d>& estimated) const {
    const AlignmentInput all = input();
    const Camera camera(relief.intrinsics());
    double sum = 0, count = 0;
    for (std::size_t v = 0; v < estimated.size(); ++v) {
      for (Eigen::Index p = 0; p < all.points.cols(); p += 5) {
        const Eigen::Vector3d point = all.points.col(p).cast<double>();
        const auto a = camera.linearize(estimated[v].inverse() * point);
        const auto b = camera.linearize(true_poses[v].inverse() * point);
        if (!a || !b) continue;
        sum += (a->pixel - b->pixel).norm();
        ++count;
      }
    }
    return sum / count;
  }
  double meanError(const AlignmentResult& result) const {
    std::vector<Eigen::Isometry3d> estimated;
    for (const ViewAlignment& view : result.views) estimated.push_back(view.map_from_camera);
    return meanError(estimated);
  }

 private:
  std::shared_ptr<const DepthImage> depthImage(const Eigen::Isometry3d& pose) const {
    auto image = std::make_shared<DepthImage>();
    image->cell_size = 2;
    image->pixel_angle = static_cast<float>(1 / relief.focal);
    image->depth = cv::Mat1f(relief.height / 2, relief.width / 2);
    image->edge = cv::Mat1b::zeros(image->depth.size());
    for (int y = 0; y < image->depth.rows; ++y) {
      for (int x = 0; x < image->depth.cols; ++x) {
        const Eigen::Vector3d point = relief.hit(pose, relief.bearing(2 * x + 0.5, 2 * y + 0.5));
        image->depth(y, x) = static_cast<float>((point - pose.translation()).norm());
      }
    }
    return image;
  }

  void addPoints(AlignmentInput& input) const {
    std::mt19937 random(7);
    std::uniform_real_distribution<double> uniform(-2, 2);
    input.points.resize(3, num_points);
    input.surfels.normals.resize(3, num_points);
    input.surfels.radii.setConstant(num_points, 0.03F);
    for (int i = 0; i < num_points; ++i) {
      const double x = uniform(random), y = uniform(random), step = 1e-4;
      const double z = Relief::heightAt(x, y);
      input.points.col(i) = Eigen::Vector3d(x, y, z).cast<float>();
      const Eigen::Vector3d normal((z - Relief::heightAt(x + step, y)) / step,
                                   (z - Relief::heightAt(x, y + step)) / step, 1);
      input.surfels.normals.col(i) = normal.normalized().cast<float>();
    }
  }
};

}  // namespace cloud_colorizer::test
