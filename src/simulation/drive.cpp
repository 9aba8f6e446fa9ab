// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause

#include "simulation/drive.hpp"

#include <array>
#include <cmath>
#include <map>

#include "alignment/motion.hpp"
#include "simulation/random.hpp"

namespace cloud_colorizer::simulation {
namespace {

constexpr double kPi = 3.14159265358979;
constexpr double kDegree = kPi / 180;
constexpr double kFast = 0.05, kSlow = 1.5;           // s between the knots of a pose's errors
constexpr double kMostStanding = 0.25;                // of a drive
constexpr double kLead = 0.5;                         // s of tf before the first scan and after the last one
constexpr std::int64_t kEpoch = 1600000000000000000;  // ns

Eigen::Isometry3d poseOf(const Eigen::Vector3d& position, double yaw, double pitch, double roll) {
  return Eigen::Translation3d(position) * Eigen::AngleAxisd(yaw, Eigen::Vector3d::UnitZ()) *
         Eigen::AngleAxisd(pitch, Eigen::Vector3d::UnitY()) * Eigen::AngleAxisd(roll, Eigen::Vector3d::UnitX());
}

/// A small motion from its rotation vector [rad] and translation [m].
Eigen::Isometry3d smallMotion(const Eigen::Vector3d& rotation, const Eigen::Vector3d& translation) {
  return alignment::motion((Twist() << rotation, translation).finished());
}

/// A smooth random process of mean 0 and standard deviation 1 whose values two knots apart hardly depend on each other.
double smoothNoise(std::uint64_t key, double time, double knot_time) {
  const double width = 0.9 * knot_time;
  const int middle = static_cast<int>(std::floor(time / knot_time));
  double sum = 0;
  double weights = 0;
  for (int knot = middle - 5; knot <= middle + 6; ++knot) {
    const double x = (time - knot * knot_time) / width;
    const double weight = std::exp(-0.5 * x * x);
    sum += weight * gaussian(keyOf(key, knot));
    weights += weight * weight;
  }
  return sum / std::sqrt(weights);
}

Eigen::Vector3d smoothNoise3(std::uint64_t key, double time, double knot_time) {
  const auto along = [&](int axis) { return smoothNoise(keyOf(key, axis), time, knot_time); };
  return {along(0), along(1), along(2)};
}

/// The way of the vehicle: forth and back, with a stop. Knots of (time, way) that a line joins.
Motion wayOf(const Options& o) {
  const double total = o.frames / o.rate, stand = std::min(o.stand, kMostStanding * total);
  const double leg = (total - stand) / o.passes, way = o.speed * leg;
  const auto along = [](double x) { return Eigen::Vector3d(x, 0, 0); };
  Motion motion{{{kLead, along(0)}}};
  double time = kLead;
  if (stand > 0) {
    motion.knots.push_back({time + leg / 2, along(way / 2)});
    motion.knots.push_back({time + leg / 2 + stand, along(way / 2)});
    time += stand;
  }
  for (int pass = 1; pass <= o.passes; ++pass) {
    time += leg;
    motion.knots.push_back({time, along(pass % 2 == 1 ? way : 0)});
  }
  return motion;
}

/// A random direction whose root mean square over the axes is 1: calibrations differ in the kind of error, not in
/// its size.
Eigen::Vector3d errorDirection(std::uint64_t key) {
  const Eigen::Vector3d v(gaussian(keyOf(key, 0)), gaussian(keyOf(key, 1)), gaussian(keyOf(key, 2)));
  return std::sqrt(3.0) * v.normalized();
}

struct Lens {
  double fx, fy;  // of the image's width
  std::vector<double> distortion;
};

Intrinsics intrinsicsOf(const Options& options, DistortionModel model) {
  static const std::map<DistortionModel, Lens> kLenses = {
      {DistortionModel::kPlumbBob, {0.56, 0.561, {-0.26, 0.075, 0.0006, -0.0004, -0.004}}},
      {DistortionModel::kRationalPolynomial, {0.575, 0.574, {0.31, 0.02, -0.0005, 0.0003, 0.001, 0.5, 0.06, 0.003}}},
      {DistortionModel::kEquidistant, {0.39, 0.3905, {-0.012, 0.004, -0.002, 0.0003}}}};
  const Lens& lens = kLenses.at(model);
  const double w = options.width;
  Intrinsics k;
  k.width = options.width;
  k.height = options.height;
  k.model = options.pinhole ? DistortionModel::kPlumbBob : model;
  k.fx = lens.fx * w;
  k.fy = lens.fy * w;
  k.cx = 0.5 * (w - 1) + 0.006 * w;
  k.cy = 0.5 * (options.height - 1) - 0.004 * w;
  if (!options.pinhole) k.distortion = lens.distortion;
  return k;
}

struct Mount {
  double x, y, z, yaw_deg;
  DistortionModel model;
};

constexpr std::array<Mount, 6> kMounts = {{
    {0.9, 0.35, 1.55, 35, DistortionModel::kPlumbBob},
    {0.9, -0.35, 1.55, -35, DistortionModel::kRationalPolynomial},
    {1.1, 0.0, 1.5, 0, DistortionModel::kEquidistant},
    {-0.6, 0.4, 1.55, 125, DistortionModel::kPlumbBob},
    {-0.6, -0.4, 1.55, -125, DistortionModel::kRationalPolynomial},
    {-0.9, 0.0, 1.5, 180, DistortionModel::kEquidistant},
}};

DriveCamera makeCamera(const Options& options, std::size_t index) {
  const Mount& mount = kMounts[index];
  const std::uint64_t key = keyOf(options.seed, 40, index);
  Eigen::Matrix3d body_from_optical;  // optical: z ahead, x right, y down
  body_from_optical << 0, 0, 1, -1, 0, 0, 0, -1, 0;
  DriveCamera camera{"camera_" + std::to_string(index),
                     "camera_" + std::to_string(index) + "_optical",
                     Camera(intrinsicsOf(options, mount.model)),
                     {},
                     {},
                     0,
                     {}};
  camera.base_from_camera = poseOf({mount.x, mount.y, mount.z}, mount.yaw_deg * kDegree, -3 * kDegree, 0.4 * kDegree);
  camera.base_from_camera.linear() *= body_from_optical;
  camera.base_from_camera_given =
      camera.base_from_camera * smallMotion(options.extrinsic_noise_deg * kDegree * errorDirection(keyOf(key, 1)),
                                            options.extrinsic_noise_m * errorDirection(keyOf(key, 2)));
  camera.delay = (0.3 + 0.25 * static_cast<double>(index % 3)) / options.rate;
  for (int c = 0; c < 3; ++c) {
    camera.white_balance[c] = static_cast<float>(1 + options.white_balance * uniform(keyOf(key, 3, c), -1, 1));
  }
  return camera;
}

}  // namespace

Drive::Drive(const Options& options) : options_(options) {
  options_.check();
  way_ = wayOf(options_);
  for (int i = 0; i < options_.cameras; ++i) cameras_.push_back(makeCamera(options_, static_cast<std::size_t>(i)));
  base_from_lidar_ = poseOf({0.0, 0.0, 1.9}, 0.5 * kDegree, 0.3 * kDegree, -0.2 * kDegree);
}

double Drive::scanTime(int frame) const {
  return kLead + frame / options_.rate;
}
double Drive::duration() const {
  return scanTime(options_.frames) + kLead;
}
double Drive::imageTime(int camera, int frame) const {
  return scanTime(frame) + cameras_.at(static_cast<std::size_t>(camera)).delay;
}
std::int64_t Drive::stamp(double time) const {
  return kEpoch + std::llround(time * 1e9);
}
std::int64_t Drive::imageStamp(int camera, int frame) const {
  return stamp(imageTime(camera, frame) + options_.time_offset);
}

Eigen::Isometry3d Drive::mapFromBase(double time) const {
  const double x = way_.at(time).x();
  // Everything else depends on the way, so that a standing vehicle stands still.
  const double phase = 2 * kPi * x / 31;
  const double y = -1.5 + 0.3 * std::sin(phase) + 0.12 * std::sin(2.7 * phase + 1);
  const double slope = 2 * kPi / 31 * (0.3 * std::cos(phase) + 0.12 * 2.7 * std::cos(2.7 * phase + 1));
  const double bounce = 0.008 * std::sin(4.1 * phase);
  return poseOf({x, y, bounce}, std::atan(slope), 0.25 * kDegree * std::sin(3.3 * phase),
                0.35 * kDegree * std::sin(2.3 * phase + 0.5));
}

Eigen::Isometry3d Drive::mapFromBaseGiven(double time) const {
  const std::uint64_t key = keyOf(options_.seed, 41);
  return mapFromBase(time) * smallMotion(options_.pose_noise_deg * kDegree * smoothNoise3(keyOf(key, 1), time, kFast),
                                         options_.pose_noise_m * smoothNoise3(keyOf(key, 2), time, kFast) +
                                             options_.drift * smoothNoise3(keyOf(key, 3), time, kSlow));
}

Eigen::Isometry3d Drive::mapFromCamera(int camera, int frame, double share) const {
  return mapFromBase(imageTime(camera, frame) + share * options_.readout) *
         cameras_.at(static_cast<std::size_t>(camera)).base_from_camera;
}

Color Drive::gain(int camera, int frame) const {
  // Two waves that together reach the largest deviation but do not pass it.
  const std::uint64_t key = keyOf(options_.seed, 42, camera);
  const double phase = 2 * kPi * frame / 17.0;
  const double wave = 0.65 * std::sin(phase + 2 * kPi * uniform(keyOf(key, 1))) +
                      0.35 * std::sin(2.31 * phase + 2 * kPi * uniform(keyOf(key, 2)));
  return cameras_.at(static_cast<std::size_t>(camera)).white_balance * static_cast<float>(1 + options_.exposure * wave);
}

StreetOptions streetOf(const Options& options) {
  StreetOptions street;
  const Motion way_of_vehicle = wayOf(options);
  double way = 0;
  for (const Motion::Knot& knot : way_of_vehicle.knots) way = std::max(way, knot.offset.x());
  street.seed = options.seed;
  street.to = std::ceil(way / 5) * 5 + 45;
  street.leaves = options.leaves;
  street.pedestrians = options.pedestrians;
  street.moving_car = options.moving_car;
  if (options.van_ahead > 0) {
    Motion ahead = way_of_vehicle;
    for (Motion::Knot& knot : ahead.knots) knot.offset.x() += options.van_ahead;
    street.van = std::make_shared<const Motion>(std::move(ahead));
  }
  // It passes the vehicle in the middle of the drive.
  const double middle = kLead + 0.5 * options.frames / options.rate;
  street.car_start = 0.5 * way - street.car_speed * middle;
  street.lighting.gloss = options.gloss;
  if (options.gloss > 0) street.lighting.to_sun = Eigen::Vector3d(0.85, -0.25, 0.42).normalized();  // low, ahead
  return street;
}

}  // namespace cloud_colorizer::simulation
