// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause
#include "evaluation/test_bed.hpp"

#include <algorithm>
#include <cmath>

#include "base/parallel.hpp"
#include "cloud_colorizer/base/check.hpp"
#include "evaluation/random.hpp"

namespace cloud_colorizer {
namespace {

/// Streams of random numbers: one for each thing that is drawn.
enum Stream : std::uint64_t { kSurfaceStream = 1, kRotationStream, kCentreStream, kGainStream, kPixelStream = 1000 };

float squareWave(float x) {
  return std::sin(x) > 0 ? 1.F : 0.F;
}

cv::Mat noisyImage(const cv::Mat& clean, double gain, double sigma, std::uint64_t stream) {
  static const std::vector<float> table = normalQuantiles(65536);
  cv::Mat noisy(clean.size(), clean.type());
  const auto width = static_cast<std::size_t>(clean.cols * clean.channels());
  for (int y = 0; y < clean.rows; ++y) {
    const auto* from = clean.ptr<std::uint8_t>(y);
    auto* to = noisy.ptr<std::uint8_t>(y);
    std::uint64_t bits = 0;
    for (std::size_t x = 0; x < width; ++x) {
      if (x % 4 == 0) bits = hash64(stream, (static_cast<std::uint64_t>(y) * width + x) / 4 * 4);
      const double noise = sigma * table[bits & 0xffff];
      bits >>= 16;
      to[x] = cv::saturate_cast<std::uint8_t>(gain * from[x] + noise);
    }
  }
  return noisy;
}

Eigen::Vector3d gaussianVector(std::uint64_t stream, std::size_t index) {
  return {gaussian(stream, 3 * index), gaussian(stream, 3 * index + 1), gaussian(stream, 3 * index + 2)};
}

Eigen::Isometry3d noisyPose(const Eigen::Isometry3d& pose, double rotation_deg, double centre, std::uint64_t seed,
                            std::size_t view) {
  constexpr double kRadians = 3.141592653589793 / 180;
  const Eigen::Vector3d turn = rotation_deg * kRadians * gaussianVector(hash64(seed, kRotationStream), view);
  Eigen::Isometry3d noisy = pose;
  if (turn.norm() > 0) noisy.rotate(Eigen::AngleAxisd(turn.norm(), turn.normalized()));
  noisy.pretranslate(centre * gaussianVector(hash64(seed, kCentreStream), view));
  return noisy;
}

}  // namespace

void TestBedParams::check() const {
  requireInRange<std::size_t>("num_points", num_points, 1, 100000000);
  requireInRange("scan_line_ratio", scan_line_ratio, 0.0, 1000.0);
  requireInRange("num_views", num_views, 1, 10000);
  requireInRange("width", width, 8, 20000);
  requireInRange("height", height, 8, 20000);
  requireInRange("focal_length", focal_length, 1.0, 1e5);
  requireInRange("fill", fill, 0.05, 1.0);
  requireInRange("texture_frequency", texture_frequency, 0.01, 100.0);
}

void NoiseParams::check() const {
  requireInRange("rotation", rotation, 0.0, 30.0);
  requireInRange("centre", centre, 0.0, 0.5);
  requireInRange("gain", gain, 0.0, 0.3);
  requireInRange("pixel", pixel, 0.0, 100.0);
}

Eigen::Vector3f textureAlbedo(const Eigen::Vector3f& point, float frequency) {
  const Eigen::Vector3f p = point * frequency;
  const float warp = 0.35F * std::sin(3.1F * p.y() + 1.7F * p.z());
  Eigen::Vector3f color(0.5F + 0.22F * std::sin(2.3F * p.x() + 1.1F * p.z() + 0.4F),
                        0.5F + 0.22F * std::sin(2.9F * p.y() - 1.9F * p.x() + 1.3F),
                        0.5F + 0.22F * std::sin(3.3F * p.z() + 1.4F * p.y() + 2.2F));
  const float region = std::sin(3.7F * (p.x() + warp)) + std::sin(3.1F * p.z() + 2.3F * p.y() + 0.8F);
  if (region > 0.9F) return color;  // smooth: nothing but low frequencies
  if (region > -0.2F) {             // sharp patches with wavelengths of 0.25 to 0.3
    const float a = squareWave(24 * (p.x() + warp)), b = squareWave(21 * p.y() + 5 * warp);
    color +=
        Eigen::Vector3f(0.18F, 0.10F, -0.12F) * (a + b - 1) + Eigen::Vector3f(-0.08F, 0.10F, 0.14F) * (a * b - 0.5F);
  } else {  // fine checks with a wavelength of 0.1 in all three directions
    const float check = squareWave(62 * p.x()) + squareWave(58 * p.y()) + squareWave(66 * p.z());
    color += Eigen::Vector3f(0.2F, 0.2F, 0.17F) * (std::fmod(check, 2.F) - 0.5F) * 1.6F;
  }
  return color.cwiseMax(0.06F).cwiseMin(0.94F);
}

Eigen::Vector3f shadedColor(const Eigen::Vector3f& point, const Eigen::Vector3f& normal, float frequency) {
  const Eigen::Vector3f key = Eigen::Vector3f(0.5F, 0.6F, 0.62F).normalized();
  const Eigen::Vector3f fill = Eigen::Vector3f(-0.7F, -0.2F, -0.5F).normalized();
  const float light = 0.60F + 0.45F * std::max(0.F, normal.dot(key)) + 0.20F * std::max(0.F, normal.dot(fill));
  return 255 * light * textureAlbedo(point, frequency);
}

std::vector<Eigen::Isometry3d> posesAround(int count, double radius) {
  constexpr double kGoldenAngle = 2.399963229728653;
  std::vector<Eigen::Isometry3d> poses;
  for (int i = 0; i < count; ++i) {
    const double z = 1 - (2 * i + 1.0) / count, ring = std::sqrt(1 - z * z);
    const Eigen::Vector3d direction(ring * std::cos(kGoldenAngle * i), ring * std::sin(kGoldenAngle * i), z);
    const Eigen::Vector3d forward = -direction;
    const Eigen::Vector3d up = std::abs(z) < 0.98 ? Eigen::Vector3d::UnitZ() : Eigen::Vector3d::UnitY();
    const Eigen::Vector3d right = forward.cross(up).normalized();
    Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
    pose.linear() << right, forward.cross(right), forward;  // x right, y down, z forward
    pose.translation() = radius * direction;
    poses.push_back(pose);
  }
  return poses;
}

TestBed renderTestBed(const Mesh& mesh, const TestBedParams& params) {
  params.check();
  Mesh object = mesh;
  normalizeMesh(object);
  const auto frequency = static_cast<float>(params.texture_frequency);
  TestBed bed;
  bed.name = mesh.name;
  const std::uint64_t seed = hash64(params.seed, kSurfaceStream);
  SurfaceSamples samples = params.scan_line_ratio > 0
                               ? sampleScanLines(object, params.num_points, params.scan_line_ratio, seed)
                               : sampleSurface(object, params.num_points, seed);
  bed.truth.resize(3, samples.points.cols());
  for (Eigen::Index p = 0; p < samples.points.cols(); ++p) {
    bed.truth.block<3, 1>(0, p) = shadedColor(samples.points.col(p), samples.normals.col(p), frequency);
  }
  bed.points = std::move(samples.points);
  bed.intrinsics.width = params.width;
  bed.intrinsics.height = params.height;
  bed.intrinsics.fx = bed.intrinsics.fy = params.focal_length;
  bed.intrinsics.cx = (params.width - 1) / 2.0;
  bed.intrinsics.cy = (params.height - 1) / 2.0;
  // A sphere of radius 1 at distance d has the apparent radius f / sqrt(d^2 - 1).
  const double radius = params.fill * std::min(params.width, params.height) / 2;
  bed.true_poses = posesAround(params.num_views, std::hypot(1, params.focal_length / radius));
  bed.poses = bed.true_poses;
  bed.gains.setOnes(params.num_views);
  bed.images.resize(bed.poses.size());
  parallelFor(params.num_threads, bed.poses.size(),
              [&](std::size_t v) { bed.images[v] = renderMesh(object, bed.intrinsics, bed.true_poses[v], frequency); });
  return bed;
}

TestBed addNoise(const TestBed& clean, const NoiseParams& noise, std::uint64_t seed, int num_threads) {
  noise.check();
  TestBed bed = clean;
  for (std::size_t v = 0; v < bed.poses.size(); ++v) {
    bed.poses[v] = noisyPose(clean.true_poses[v], noise.rotation, noise.centre * clean.diameter, seed, v);
    // Beyond three standard deviations an exposure would be no noise but a fault.
    const double draw = std::clamp(gaussian(hash64(seed, kGainStream), v), -3.0, 3.0);
    bed.gains[static_cast<Eigen::Index>(v)] = 1 + noise.gain * draw;
  }
  if (noise.gain == 0 && noise.pixel == 0) return bed;
  parallelFor(num_threads, bed.images.size(), [&](std::size_t v) {
    const double gain = bed.gains[static_cast<Eigen::Index>(v)];
    bed.images[v] = noisyImage(clean.images[v], gain, noise.pixel, hash64(seed, kPixelStream + v));
  });
  return bed;
}

TestBed noisyBed(const Mesh& mesh, const TestBedParams& params, const NoiseParams& noise) {
  return addNoise(renderTestBed(mesh, params), noise, params.seed, params.num_threads);
}

double meanReprojectionError(const TestBed& bed, const std::vector<Eigen::Isometry3d>& poses) {
  const Intrinsics& k = bed.intrinsics;
  const auto pixel = [&k](const Eigen::Vector3d& p) {
    return Eigen::Vector2d(k.fx * p.x() / p.z() + k.cx, k.fy * p.y() / p.z() + k.cy);
  };
  require<std::invalid_argument>(poses.size() == bed.true_poses.size(), poses.size(), " poses for ",
                                 bed.true_poses.size(), " views");
  const Eigen::Index step = std::max<Eigen::Index>(1, bed.points.cols() / 2000);
  double sum = 0;
  std::size_t count = 0;
  for (std::size_t v = 0; v < poses.size(); ++v) {
    for (Eigen::Index p = 0; p < bed.points.cols(); p += step) {
      const Eigen::Vector3d point = bed.points.col(p).cast<double>();
      const Eigen::Vector3d truth = bed.true_poses[v].inverse() * point, given = poses[v].inverse() * point;
      if (truth.z() <= 0 || given.z() <= 0) continue;
      sum += (pixel(truth) - pixel(given)).norm();
      ++count;
    }
  }
  return count == 0 ? 0 : sum / static_cast<double>(count);
}

}  // namespace cloud_colorizer
