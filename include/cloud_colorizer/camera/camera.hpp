// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause

/// Camera models as in sensor_msgs/CameraInfo. Pixel centres lie at integers (ROS, OpenCV), not at +0.5 (COLMAP).
#pragma once

#include <Eigen/Core>
#include <array>
#include <cmath>
#include <optional>
#include <string>
#include <vector>

namespace cloud_colorizer {

/// kEquirectangular: a panorama of all directions, twice as wide as high, whose other numbers say nothing. It is cut
/// into pinhole images before anything else; Camera does not project with it.
enum class DistortionModel { kPlumbBob, kRationalPolynomial, kEquidistant, kEquirectangular };

/// The name that sensor_msgs/CameraInfo uses for the model, and back (throws std::invalid_argument on another name).
std::string toString(DistortionModel model);
DistortionModel distortionModelFromString(const std::string& name);

/// A small motion of a camera in its own frame: rotation [rad], then translation [m].
using Twist = Eigen::Matrix<double, 6, 1>;

/// Plain numbers of one camera. `distortion`: plumb_bob k1 k2 p1 p2 k3; rational_polynomial k1 k2 p1 p2 k3 k4 k5 k6;
/// equidistant k1 k2 k3 k4. Missing trailing coefficients are zero.
struct Intrinsics {
  int width = 0, height = 0;              ///< px
  double fx = 0, fy = 0, cx = 0, cy = 0;  ///< px
  DistortionModel model = DistortionModel::kPlumbBob;
  std::vector<double> distortion;
};

inline bool isPanorama(const Intrinsics& intrinsics) {
  return intrinsics.model == DistortionModel::kEquirectangular;
}

/// Projects points of the optical frame (z forward, x right, y down) into the image.
/// A point is projected only where the model is one-to-one: its angle to the optical axis is below maxAngle(), the
/// first angle at which the distorted radius stops growing. So nothing from outside the field of view folds back.
class Camera {
 public:
  /// Throws std::invalid_argument, with the value, when a focal length or size is not positive, a number is not
  /// finite, or there are more coefficients than the model has.
  explicit Camera(const Intrinsics& intrinsics);

  /// The same camera with a rolling shutter, which moved so from the first row of its image to the last. The frame of
  /// the points that it projects is the one of the middle row; each is projected as of the moment when the row was read
  /// in which it appears. Zeros: all rows were read at once.
  Camera whileMoving(const Twist& readout_motion) const;

  const Intrinsics& intrinsics() const { return intrinsics_; }
  double pixelAngle() const { return 1 / std::sqrt(intrinsics_.fx * intrinsics_.fy); }  ///< rad, in the middle
  double maxAngle() const { return max_angle_; }                                        ///< rad, from the optical axis

  /// Pixel (u, v) of a point in the camera's frame [m]; empty when behind, beyond maxAngle() or outside the image
  /// ([-0.5, width - 0.5) x [-0.5, height - 0.5)).
  std::optional<Eigen::Vector2f> project(const Eigen::Vector3f& point) const {
    if (!mayShow(point, 0.0F)) return std::nullopt;
    auto pixel = projectUnbounded(point);
    if (!pixel || !contains(pixel->x(), pixel->y())) return std::nullopt;
    return pixel;
  }

  /// The same without the bounds of the image: empty only behind and beyond maxAngle().
  std::optional<Eigen::Vector2f> projectUnbounded(const Eigen::Vector3f& point) const;

  /// Cheap and conservative: false only when no point within `margin` [m] of `point` is in the image.
  bool mayShow(const Eigen::Vector3f& point, float margin) const {
    return isRolling() ? mayShowAtOnce(point, margin + reach(point.norm() + margin)) : mayShowAtOnce(point, margin);
  }
  /// m, by which the motion while the image is read moves what is at a distance [m] at most.
  float reach(float distance) const { return half_turn_ * distance + half_way_; }

  template <class Scalar>
  struct LinearizedT {
    Eigen::Matrix<Scalar, 2, 1> pixel;
    Eigen::Matrix<Scalar, 2, 3> jacobian;  ///< d pixel / d point [px / m]
  };
  using Linearized = LinearizedT<double>;

  /// As project, in double and with the derivative.
  std::optional<Linearized> linearize(const Eigen::Vector3d& point) const;
  /// As projectUnbounded, in float and with the derivative.
  std::optional<LinearizedT<float>> linearizeUnbounded(const Eigen::Vector3f& point) const;

  /// Unit bearing of a pixel (the inverse of project, to 1e-9 rad) in the frame of the moment when its row was read;
  /// empty where the model has no inverse.
  std::optional<Eigen::Vector3d> bearing(const Eigen::Vector2d& pixel) const;

 private:
  /// One precision's copy of all that projection needs. k: k1 k2 p1 p2 k3 k4 k5 k6, or k1 k2 k3 k4 of equidistant.
  template <class Scalar>
  struct Numbers {
    Scalar fx, fy, cx, cy;
    std::array<Scalar, 8> k;
    Scalar cos_max, tan2_max;
  };
  template <class Scalar>
  struct Radial {
    Scalar scale, slope;  ///< distorted radius / radius, and its derivative by the squared radius
    bool valid;
  };
  template <class Scalar>
  using Vector2 = Eigen::Matrix<Scalar, 2, 1>;
  template <class Scalar>
  using Vector3 = Eigen::Matrix<Scalar, 3, 1>;

  template <class Scalar>
  static Radial<Scalar> radial(const Numbers<Scalar>& n, Scalar r2);
  template <class Scalar>
  static Vector2<Scalar> distort(const Numbers<Scalar>& n, Scalar x, Scalar y, Scalar scale);
  template <class Scalar>
  static Scalar distortAngle(const Numbers<Scalar>& n, Scalar angle);
  template <class Scalar>
  std::optional<Vector2<Scalar>> map(const Numbers<Scalar>& n, const Vector3<Scalar>& point) const;
  template <class Scalar>
  Vector3<Scalar> whenRead(const Numbers<Scalar>& n, const Vector3<Scalar>& point) const;
  template <class Scalar>
  std::optional<LinearizedT<Scalar>> mapLinear(const Numbers<Scalar>& n, const Vector3<Scalar>& point) const;
  template <class Scalar>
  static LinearizedT<Scalar> linearizePinhole(const Numbers<Scalar>& n, const Vector3<Scalar>& point);
  template <class Scalar>
  static LinearizedT<Scalar> linearizeEquidistant(const Numbers<Scalar>& n, const Vector3<Scalar>& point);
  bool isRolling() const { return half_turn_ > 0 || half_way_ > 0; }
  bool mayShowAtOnce(const Eigen::Vector3f& point, float margin) const;
  bool contains(float u, float v) const { return u >= -0.5F && v >= -0.5F && u < right_ && v < bottom_; }
  double growth(double angle) const;
  double findMaxAngle() const;
  double angleOfRadius(double distorted_radius) const;
  void boundFieldOfView();

  Intrinsics intrinsics_;
  bool equidistant_ = false;
  double max_angle_ = 0;
  Numbers<double> exact_{};
  Numbers<float> fast_{};
  float right_ = 0, bottom_ = 0;  ///< px, ends of the image
  /// What the image can show: half-planes through the camera's centre (pinhole), or a cone (equidistant).
  Eigen::Vector4f side_ = Eigen::Vector4f::Zero();         ///< left, right, top, bottom as x/z, x/z, y/z, y/z
  Eigen::Vector4f side_margin_ = Eigen::Vector4f::Ones();  ///< sqrt(1 + side^2)
  float cone_cos_ = -1, cone_sin_ = 0;
  Twist motion_ = Twist::Zero();        ///< from the first row to the last
  float half_turn_ = 0, half_way_ = 0;  ///< rad and m, of half of it
};

inline bool Camera::mayShowAtOnce(const Eigen::Vector3f& point, float margin) const {
  const float x = point.x(), y = point.y(), z = point.z();
  if (equidistant_) {
    // Distance to the cone's surface; exact on its side, and an underestimate behind its apex.
    return cone_sin_ * z - cone_cos_ * std::sqrt(x * x + y * y) >= -margin || x * x + y * y + z * z <= margin * margin;
  }
  return z > -margin && x >= side_[0] * z - margin * side_margin_[0] && x <= side_[1] * z + margin * side_margin_[1] &&
         y >= side_[2] * z - margin * side_margin_[2] && y <= side_[3] * z + margin * side_margin_[3];
}

template <class Scalar>
Camera::Radial<Scalar> Camera::radial(const Numbers<Scalar>& n, Scalar r2) {
  const auto& k = n.k;
  const Scalar up = 1 + r2 * (k[0] + r2 * (k[1] + r2 * k[4]));
  const Scalar up_slope = k[0] + r2 * (2 * k[1] + r2 * 3 * k[4]);
  const Scalar down = 1 + r2 * (k[5] + r2 * (k[6] + r2 * k[7]));
  const Scalar down_slope = k[5] + r2 * (2 * k[6] + r2 * 3 * k[7]);
  return {up / down, (up_slope * down - up * down_slope) / (down * down), down > 0};
}

template <class Scalar>
Camera::Vector2<Scalar> Camera::distort(const Numbers<Scalar>& n, Scalar x, Scalar y, Scalar scale) {
  const Scalar p1 = n.k[2], p2 = n.k[3];
  const Scalar xy2 = 2 * x * y, r2 = x * x + y * y;
  return {x * scale + p1 * xy2 + p2 * (r2 + 2 * x * x), y * scale + p1 * (r2 + 2 * y * y) + p2 * xy2};
}

template <class Scalar>
Scalar Camera::distortAngle(const Numbers<Scalar>& n, Scalar angle) {
  const Scalar a2 = angle * angle;
  return angle * (1 + a2 * (n.k[0] + a2 * (n.k[1] + a2 * (n.k[2] + a2 * n.k[3]))));
}

template <class Scalar>
std::optional<Camera::Vector2<Scalar>> Camera::map(const Numbers<Scalar>& n, const Vector3<Scalar>& point) const {
  const Scalar x = point.x(), y = point.y(), z = point.z();
  const Scalar side2 = x * x + y * y;
  Vector2<Scalar> image;
  if (equidistant_) {
    const Scalar length = std::sqrt(side2 + z * z);
    if (!(z > n.cos_max * length)) return std::nullopt;
    const Scalar side = std::sqrt(side2);
    const Scalar scale = side > Scalar(1e-6) * length ? distortAngle(n, std::atan2(side, z)) / side : 1 / z;
    image = {x * scale, y * scale};
  } else {
    if (!(z > 0) || !(side2 < n.tan2_max * z * z)) return std::nullopt;
    const Scalar xn = x / z, yn = y / z;
    image = distort(n, xn, yn, radial(n, xn * xn + yn * yn).scale);
  }
  return Vector2<Scalar>(n.fx * image.x() + n.cx, n.fy * image.y() + n.cy);
}

inline std::optional<Eigen::Vector2f> Camera::projectUnbounded(const Eigen::Vector3f& point) const {
  return isRolling() ? map(fast_, whenRead(fast_, point)) : map(fast_, point);
}

}  // namespace cloud_colorizer
