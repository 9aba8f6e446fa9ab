// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause
#include "cloud_colorizer/camera/camera.hpp"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>

#include "cloud_colorizer/base/check.hpp"

namespace cloud_colorizer {
namespace {

constexpr double kPi = 3.14159265358979323846;
/// A pinhole sees less than a half space; one thousandth of a radian keeps the tangent finite.
constexpr double kMaxPinholeAngle = kPi / 2 - 1e-3;
constexpr int kScanSteps = 4096;
constexpr int kBisections = 60;

std::size_t numCoefficients(DistortionModel model) {
  if (model == DistortionModel::kPlumbBob) return 5;
  return model == DistortionModel::kRationalPolynomial ? 8 : 4;
}

void checkNumbers(const Intrinsics& in) {
  using Invalid = std::invalid_argument;
  require<Invalid>(in.width > 0 && in.height > 0, "camera: image size ", in.width, " x ", in.height,
                   " px is not positive");
  for (const double number : {in.fx, in.fy, in.cx, in.cy}) {
    require<Invalid>(std::isfinite(number), "camera: an intrinsic number (fx, fy, cx, cy = ", in.fx, ", ", in.fy, ", ",
                     in.cx, ", ", in.cy, ") is not finite");
  }
  require<Invalid>(in.fx > 0 && in.fy > 0, "camera: focal lengths ", in.fx, ", ", in.fy,
                   " px are not positive; a camera_info with K[0] = 0 comes from an uncalibrated camera: calibrate it");
  for (std::size_t i = 0; i < in.distortion.size(); ++i) {
    require<Invalid>(std::isfinite(in.distortion[i]), "camera: distortion coefficient ", i, " = ", in.distortion[i],
                     " is not finite");
  }
  require<Invalid>(in.model != DistortionModel::kEquirectangular,
                   "camera: an equirectangular image must be cut into pinhole images first");
  const std::size_t most = numCoefficients(in.model), given = in.distortion.size();
  const bool looks_rational = in.model == DistortionModel::kPlumbBob && given == 8;
  require<Invalid>(given <= most, "camera: ", toString(in.model), " has at most ", most, " coefficients, not ", given,
                   looks_rational ? "; this looks like rational_polynomial" : "");
}

}  // namespace

std::string toString(DistortionModel model) {
  if (model == DistortionModel::kPlumbBob) return "plumb_bob";
  if (model == DistortionModel::kEquirectangular) return "equirectangular";
  return model == DistortionModel::kRationalPolynomial ? "rational_polynomial" : "equidistant";
}

DistortionModel distortionModelFromString(const std::string& name) {
  for (const auto model :
       {DistortionModel::kPlumbBob, DistortionModel::kRationalPolynomial, DistortionModel::kEquidistant}) {
    if (name == toString(model)) return model;
  }
  throw std::invalid_argument("unknown distortion model \"" + name +
                              "\"; known are plumb_bob, rational_polynomial and equidistant");
}

Camera::Camera(const Intrinsics& intrinsics)
    : intrinsics_(intrinsics), equidistant_(intrinsics.model == DistortionModel::kEquidistant) {
  checkNumbers(intrinsics);
  exact_ = {intrinsics.fx, intrinsics.fy, intrinsics.cx, intrinsics.cy, {}, -1, 0};
  std::copy(intrinsics.distortion.begin(), intrinsics.distortion.end(), exact_.k.begin());
  max_angle_ = findMaxAngle();
  exact_.cos_max = std::cos(max_angle_);
  exact_.tan2_max = equidistant_ ? 0 : std::pow(std::tan(max_angle_), 2);
  const auto narrow = [](double number) { return static_cast<float>(number); };
  fast_ = {narrow(exact_.fx),      narrow(exact_.fy),      narrow(exact_.cx), narrow(exact_.cy), {},
           narrow(exact_.cos_max), narrow(exact_.tan2_max)};
  std::transform(exact_.k.begin(), exact_.k.end(), fast_.k.begin(), narrow);
  right_ = static_cast<float>(intrinsics.width) - 0.5F;
  bottom_ = static_cast<float>(intrinsics.height) - 0.5F;
  boundFieldOfView();
}

/// Positive while the distorted radius grows with the angle (the sign of its derivative).
double Camera::growth(double angle) const {
  if (equidistant_) {
    const double a2 = angle * angle;
    const auto& k = exact_.k;
    return 1 + a2 * (3 * k[0] + a2 * (5 * k[1] + a2 * (7 * k[2] + a2 * 9 * k[3])));
  }
  const double r2 = std::pow(std::tan(angle), 2);
  const auto factor = radial(exact_, r2);
  return factor.valid ? factor.scale + 2 * r2 * factor.slope : -1.0;
}

double Camera::findMaxAngle() const {
  const double end = equidistant_ ? kPi : kMaxPinholeAngle;
  double low = 0;
  for (int i = 1; i <= kScanSteps; ++i) {
    double high = end * i / kScanSteps;
    if (growth(high) > 0) {
      low = high;
      continue;
    }
    for (int j = 0; j < kBisections; ++j) {
      const double middle = (low + high) / 2;
      (growth(middle) > 0 ? low : high) = middle;
    }
    return low;
  }
  return end;
}

template <class Scalar>
Camera::LinearizedT<Scalar> Camera::linearizePinhole(const Numbers<Scalar>& n, const Vector3<Scalar>& point) {
  const Scalar inverse = 1 / point.z(), x = point.x() * inverse, y = point.y() * inverse;
  const auto [scale, slope, valid] = radial(n, x * x + y * y);
  const Scalar p1 = n.k[2], p2 = n.k[3];
  const Scalar cross = 2 * slope * x * y + 2 * p1 * x + 2 * p2 * y;
  const Scalar xx = n.fx * (scale + 2 * slope * x * x + 2 * p1 * y + 6 * p2 * x);
  const Scalar yy = n.fy * (scale + 2 * slope * y * y + 6 * p1 * y + 2 * p2 * x);
  const Scalar xy = n.fx * cross, yx = n.fy * cross;
  const Vector2<Scalar> image = distort(n, x, y, scale);
  LinearizedT<Scalar> out;
  out.pixel = {n.fx * image.x() + n.cx, n.fy * image.y() + n.cy};
  out.jacobian << xx * inverse, xy * inverse, -(xx * x + xy * y) * inverse,  //
      yx * inverse, yy * inverse, -(yx * x + yy * y) * inverse;
  return out;
}

template <class Scalar>
Camera::LinearizedT<Scalar> Camera::linearizeEquidistant(const Numbers<Scalar>& n, const Vector3<Scalar>& point) {
  const Scalar x = point.x(), y = point.y(), z = point.z();
  const Scalar side2 = x * x + y * y, length2 = side2 + z * z, side = std::sqrt(side2);
  Scalar scale = 1 / z, across = 0, along = -1 / (z * z);
  if (side > Scalar(1e-6) * std::sqrt(length2)) {
    const Scalar angle = std::atan2(side, z), a2 = angle * angle;
    const auto& k = n.k;
    const Scalar slope = 1 + a2 * (3 * k[0] + a2 * (5 * k[1] + a2 * (7 * k[2] + a2 * 9 * k[3])));
    scale = distortAngle(n, angle) / side;
    across = (slope * z / length2 - scale) / side2;
    along = -slope / length2;
  }
  LinearizedT<Scalar> out;
  out.pixel = {n.fx * x * scale + n.cx, n.fy * y * scale + n.cy};
  out.jacobian << n.fx * (scale + across * x * x), n.fx * across * x * y, n.fx * along * x,  //
      n.fy * across * x * y, n.fy * (scale + across * y * y), n.fy * along * y;
  return out;
}

template <class Scalar>
std::optional<Camera::LinearizedT<Scalar>> Camera::mapLinear(const Numbers<Scalar>& n,
                                                             const Vector3<Scalar>& point) const {
  const Scalar z = point.z();
  if (equidistant_) {
    if (!(z > n.cos_max * point.norm())) return std::nullopt;
    return linearizeEquidistant(n, point);
  }
  if (!(z > 0) || !(point.template head<2>().squaredNorm() < n.tan2_max * z * z)) return std::nullopt;
  return linearizePinhole(n, point);
}

Camera Camera::whileMoving(const Twist& readout_motion) const {
  using Invalid = std::invalid_argument;
  require<Invalid>(readout_motion.allFinite(), "the motion of a camera while its image is read is not finite");
  Camera moving = *this;
  moving.motion_ = readout_motion;
  moving.half_turn_ = static_cast<float>(readout_motion.head<3>().norm() / 2);
  moving.half_way_ = static_cast<float>(readout_motion.tail<3>().norm() / 2);
  return moving;
}

/// The point in the frame of the moment when its row was read: where it appears tells the row, which tells where it
/// appears. A round leaves a share of the error, by how many rows the image of the point moves while one is read.
template <class Scalar>
Camera::Vector3<Scalar> Camera::whenRead(const Numbers<Scalar>& n, const Vector3<Scalar>& point) const {
  constexpr int kRounds = 3;
  const auto height = static_cast<Scalar>(intrinsics_.height);
  const Vector3<Scalar> turn = motion_.head<3>().cast<Scalar>();
  const Vector3<Scalar> way = motion_.tail<3>().cast<Scalar>() + turn.cross(point);
  Vector3<Scalar> moved = point;
  for (int round = 0; round < kRounds; ++round) {
    const auto pixel = map(n, moved);
    if (!pixel) break;
    const Scalar row = (pixel->y() + Scalar(0.5)) / height - Scalar(0.5);
    moved = point - std::min(Scalar(0.5), std::max(Scalar(-0.5), row)) * way;
  }
  return moved;
}
template Eigen::Vector3f Camera::whenRead(const Numbers<float>&, const Eigen::Vector3f&) const;

std::optional<Camera::Linearized> Camera::linearize(const Eigen::Vector3d& point) const {
  auto out = mapLinear(exact_, isRolling() ? whenRead(exact_, point) : point);
  if (!out || !contains(static_cast<float>(out->pixel.x()), static_cast<float>(out->pixel.y()))) return std::nullopt;
  return out;
}

std::optional<Camera::LinearizedT<float>> Camera::linearizeUnbounded(const Eigen::Vector3f& point) const {
  return mapLinear(fast_, isRolling() ? whenRead(fast_, point) : point);
}

/// Angle whose distorted radius (without tangential terms) is the given one; maxAngle() when none is.
double Camera::angleOfRadius(double distorted_radius) const {
  double low = 0, high = max_angle_;
  for (int i = 0; i < kBisections; ++i) {
    const double middle = (low + high) / 2, r = equidistant_ ? 0 : std::tan(middle);
    const double at = equidistant_ ? distortAngle(exact_, middle) : r * radial(exact_, r * r).scale;
    (at < distorted_radius ? low : high) = middle;
  }
  return low;
}

std::optional<Eigen::Vector3d> Camera::bearing(const Eigen::Vector2d& pixel) const {
  const Eigen::Vector2d image((pixel.x() - exact_.cx) / exact_.fx, (pixel.y() - exact_.cy) / exact_.fy);
  const double radius = image.norm();
  if (!std::isfinite(radius)) return std::nullopt;
  const double angle = angleOfRadius(radius);
  if (equidistant_) {
    if (radius > distortAngle(exact_, max_angle_)) return std::nullopt;
    const Eigen::Vector2d side = radius > 0 ? Eigen::Vector2d(image * (std::sin(angle) / radius)) : image;
    return Eigen::Vector3d(side.x(), side.y(), std::cos(angle));
  }
  Eigen::Vector3d point(0, 0, 1);
  if (radius > 0) point.head<2>() = image * (std::tan(std::min(angle, 0.999 * max_angle_)) / radius);
  // Newton for the tangential terms. The radial inverse above is its start, near enough to stay on the right branch.
  for (int i = 0; i < 20; ++i) {
    const auto at = linearizePinhole(exact_, point);
    const Eigen::Vector2d step = at.jacobian.leftCols<2>().inverse() * (pixel - at.pixel);
    if (!step.allFinite()) return std::nullopt;
    point.head<2>() += step;
    if (step.norm() > 1e-13 * (1 + point.norm())) continue;
    if (point.head<2>().squaredNorm() < exact_.tan2_max) return point.normalized();
    return std::nullopt;
  }
  return std::nullopt;
}

/// Bounds the bearings of the image by those of its border. Where the border has none, maxAngle() is the bound.
void Camera::boundFieldOfView() {
  constexpr int kSamples = 64;
  const double limit = equidistant_ ? max_angle_ : std::tan(max_angle_);
  Eigen::Vector4d side(limit, -limit, limit, -limit);
  double angle = 0;
  bool whole = true;
  const auto visit = [&](double u, double v) {
    const auto ray = bearing({u, v});
    if (!ray) {
      whole = false;
      return;
    }
    angle = std::max(angle, std::acos(std::min(1.0, std::max(-1.0, ray->z()))));
    const double x = ray->x() / ray->z(), y = ray->y() / ray->z();
    side = {std::min(side[0], x), std::max(side[1], x), std::min(side[2], y), std::max(side[3], y)};
  };
  for (int i = 0; i <= kSamples; ++i) {
    const double u = -0.5 + double(i) * intrinsics_.width / kSamples;
    const double v = -0.5 + double(i) * intrinsics_.height / kSamples;
    visit(u, -0.5), visit(u, intrinsics_.height - 0.5), visit(-0.5, v), visit(intrinsics_.width - 0.5, v);
  }
  if (!whole) side = {-limit, limit, -limit, limit};
  // Between samples the border may bulge: one part in a hundred of the width is more than any lens does.
  const double slack_x = 0.01 * (side[1] - side[0]), slack_y = 0.01 * (side[3] - side[2]);
  side_ = (side + Eigen::Vector4d(-slack_x, slack_x, -slack_y, slack_y)).cast<float>();
  side_margin_ = (side_.array().square() + 1).sqrt();
  // The principal point may lie outside the image; the cone is about the optical axis all the same.
  const double cone = whole ? std::min(max_angle_, 1.01 * angle) : max_angle_;
  cone_cos_ = static_cast<float>(std::cos(cone));
  cone_sin_ = static_cast<float>(std::sin(cone));
}

}  // namespace cloud_colorizer
