// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause
#include "evaluation/refine_pose.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "alignment/motion.hpp"
#include "evaluation/score.hpp"

namespace cloud_colorizer {
namespace {

using Eigen::Index;
using Vector6 = Twist;
using Matrix6 = Eigen::Matrix<double, 6, 6>;

constexpr Index kMinPoints = 100, kMaxPoints = 30000;
constexpr double kHuber = 15;  // grey levels

double greyOf(const Eigen::Vector3f& color) {
  return 0.299 * static_cast<double>(color[0]) + 0.587 * static_cast<double>(color[1]) +
         0.114 * static_cast<double>(color[2]);
}

/// Value and gradient, bilinear; false outside.
bool sample(const cv::Mat1f& image, const Eigen::Vector2d& pixel, double* value, Eigen::RowVector2d* gradient) {
  const int x = static_cast<int>(std::floor(pixel.x())), y = static_cast<int>(std::floor(pixel.y()));
  if (x < 0 || y < 0 || x + 1 >= image.cols || y + 1 >= image.rows) return false;
  const double ax = pixel.x() - x, ay = pixel.y() - y;
  const double a = static_cast<double>(image(y, x)), b = static_cast<double>(image(y, x + 1));
  const double c = static_cast<double>(image(y + 1, x)), d = static_cast<double>(image(y + 1, x + 1));
  *value = (a * (1 - ax) + b * ax) * (1 - ay) + (c * (1 - ax) + d * ax) * ay;
  *gradient << (b - a) * (1 - ay) + (d - c) * ay, (c - a) * (1 - ax) + (d - b) * ax;
  return true;
}

class Problem {
 public:
  Problem(PointsRef points, ValuesRef colors, const Camera& camera) : camera_(camera) {
    const Index step = std::max<Index>(1, points.cols() / kMaxPoints);
    for (Index p = 0; p < points.cols(); p += step) {
      points_.push_back(points.col(p).cast<double>());
      greys_.push_back(greyOf(colors.col(p)));
    }
  }

  /// Mean Huber cost; with the normal equations of a small motion (rotation, translation) of the camera's frame.
  double linearize(const cv::Mat1f& image, const Eigen::Isometry3d& camera_from_map, Matrix6* h, Vector6* g) {
    updateGain(image, camera_from_map);
    h->setZero();
    g->setZero();
    double cost = 0;
    int count = 0;
    for (std::size_t k = 0; k < points_.size(); ++k) {
      const Eigen::Vector3d local = camera_from_map * points_[k];
      const auto projected = camera_.linearize(local);
      double value = 0;
      Eigen::RowVector2d gradient;
      if (!projected || !sample(image, projected->pixel, &value, &gradient)) continue;
      const double residual = value - gain_ * greys_[k], size = std::abs(residual);
      const double weight = size <= kHuber ? 1 : kHuber / size;
      cost += size <= kHuber ? residual * residual / 2 : kHuber * (size - kHuber / 2);
      ++count;
      const Eigen::RowVector3d by_point = gradient * projected->jacobian;
      Vector6 jacobian;
      jacobian << local.cross(by_point.transpose()), by_point.transpose();
      *h += weight * jacobian * jacobian.transpose();
      *g += weight * residual * jacobian;
    }
    return count < kMinPoints ? 1e30 : cost / count;
  }

 private:
  void updateGain(const cv::Mat1f& image, const Eigen::Isometry3d& camera_from_map) {
    std::vector<float> seen, map;
    for (std::size_t k = 0; k < points_.size(); k += 4) {
      const auto projected = camera_.linearize(camera_from_map * points_[k]);
      double value = 0;
      Eigen::RowVector2d gradient;
      if (!projected || !sample(image, projected->pixel, &value, &gradient)) continue;
      seen.push_back(static_cast<float>(value));
      map.push_back(static_cast<float>(greys_[k]));
    }
    gain_ = bestGain(seen, map);
  }

  const Camera& camera_;
  std::vector<Eigen::Vector3d> points_;
  std::vector<double> greys_;
  double gain_ = 1;
};

}  // namespace

Eigen::Isometry3d refinePose(PointsRef points, ValuesRef colors, const Camera& camera, const cv::Mat3b& image,
                             const Eigen::Isometry3d& map_from_camera) {
  if (points.cols() < kMinPoints) return map_from_camera;
  constexpr int kRounds = 8;
  Problem problem(points, colors, camera);
  cv::Mat1b bytes;
  cv::Mat1f grey;
  cv::cvtColor(image, bytes, cv::COLOR_RGB2GRAY);
  bytes.convertTo(grey, CV_32F);
  Eigen::Isometry3d pose = map_from_camera.inverse();
  for (const double sigma : {4.0, 2.0, 1.0}) {
    cv::Mat1f blurred;
    cv::GaussianBlur(grey, blurred, cv::Size(), sigma);
    Matrix6 h;
    Vector6 g;
    double cost = problem.linearize(blurred, pose, &h, &g);
    double damping = 1e-3;
    for (int round = 0; round < kRounds; ++round) {
      Matrix6 damped = h;
      damped.diagonal() *= 1 + damping;
      damped.diagonal().array() += 1e-9;
      const Eigen::Isometry3d candidate = alignment::motion(-damped.ldlt().solve(g)) * pose;
      Matrix6 new_h;
      Vector6 new_g;
      const double new_cost = problem.linearize(blurred, candidate, &new_h, &new_g);
      damping *= new_cost < cost ? 0.3 : 10;
      if (!(new_cost < cost)) continue;
      pose = candidate;
      h = new_h;
      g = new_g;
      cost = new_cost;
    }
  }
  return pose.inverse();
}

}  // namespace cloud_colorizer
