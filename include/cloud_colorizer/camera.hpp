// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause

/// Camera models as in sensor_msgs/CameraInfo. Pixel centres lie at integers (ROS, OpenCV), not at +0.5 (COLMAP).
#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

namespace cloud_colorizer {

enum class DistortionModel { kPlumbBob, kRationalPolynomial, kEquidistant };

/// The name that sensor_msgs/CameraInfo uses for the model, and back (throws std::invalid_argument on another name).
std::string toString(DistortionModel model);
DistortionModel distortionModelFromString(const std::string& name);

/// Plain numbers of one camera. `distortion`: plumb_bob k1 k2 p1 p2 k3; rational_polynomial k1 k2 p1 p2 k3 k4 k5 k6;
/// equidistant k1 k2 k3 k4. Missing trailing coefficients are zero.
struct Intrinsics {
  int width = 0, height = 0;              ///< px
  double fx = 0, fy = 0, cx = 0, cy = 0;  ///< px
  DistortionModel model = DistortionModel::kPlumbBob;
  std::vector<double> distortion;
};

/// Projects points of the optical frame (z forward, x right, y down) into the image.
/// A point is projected only where the model is one-to-one: its angle to the optical axis is below maxAngle(), the
/// first angle at which the distorted radius stops growing. So nothing from outside the field of view folds back.
class Camera {
 public:
  /// Throws std::invalid_argument, with the value, when a focal length or size is not positive, a number is not
  /// finite, or there are more coefficients than the model has.
  explicit Camera(const Intrinsics& intrinsics);

  const Intrinsics& intrinsics() const { return intrinsics_; }
  double maxAngle() const { return max_angle_; }  ///< rad, from the optical axis

  /// Pixel (u, v) of a point in the camera's frame [m]; empty when behind, beyond maxAngle() or outside the image
  /// ([-0.5, width - 0.5) x [-0.5, height - 0.5)).
  std::optional<Eigen::Vector2f> project(const Eigen::Vector3f& point) const;

  struct Linearized {
    Eigen::Vector2d pixel;
    Eigen::Matrix<double, 2, 3> jacobian;  ///< d pixel / d point [px / m]
  };
  /// The same in double with its derivative.
  std::optional<Linearized> linearize(const Eigen::Vector3d& point) const;

  /// Unit bearing of a pixel (the inverse of project, to 1e-9 rad); empty where the model has no inverse.
  std::optional<Eigen::Vector3d> bearing(const Eigen::Vector2d& pixel) const;

 private:
  Intrinsics intrinsics_;
  double max_angle_ = 0;
};

}  // namespace cloud_colorizer
