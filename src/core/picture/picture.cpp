// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause
#include "cloud_colorizer/picture/picture.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <opencv2/imgproc.hpp>
#include <stdexcept>

#include "cloud_colorizer/base/check.hpp"

namespace cloud_colorizer {
namespace {

constexpr int kSupersampling = 2;
constexpr float kNear = 0.1F;         // m
constexpr float kSameSurface = 1.5F;  // point sizes behind the front that still blend with it
constexpr float kMaxRadius = 40;      // px, of the supersampled picture

/// A disc of the supersampled picture.
struct Disc {
  float u, v, z, radius;
};

class Canvas {
 public:
  Canvas(const Eigen::Isometry3d& map_from_camera, const PictureParams& params)
      : camera_from_map_(map_from_camera.inverse().cast<float>()),
        depth_(params.height * kSupersampling, params.width * kSupersampling, std::numeric_limits<float>::infinity()),
        sum_(depth_.rows, depth_.cols, cv::Vec4f::all(0)),
        size_(static_cast<float>(params.point_size)) {
    const double half_angle = params.field_of_view * M_PI / 360;
    focal_ = static_cast<float>(0.5 * depth_.cols / std::tan(half_angle));
  }

  void addDepth(PointsRef points) {
    for (Eigen::Index i = 0; i < points.cols(); ++i) {
      const Disc disc = project(points.col(i));
      forEachPixel(disc, [&](int row, int col, float) {
        float& depth = depth_(row, col);
        depth = std::min(depth, disc.z);
      });
    }
  }

  void addColors(PointsRef points, ValuesRef colors) {
    for (Eigen::Index i = 0; i < points.cols(); ++i) {
      const Disc disc = project(points.col(i));
      const float behind = disc.z - kSameSurface * size_ - 0.005F * disc.z;
      forEachPixel(disc, [&](int row, int col, float closeness) {
        if (behind > depth_(row, col)) return;
        const float weight = closeness * closeness + 1e-3F;
        sum_(row, col) += weight * cv::Vec4f(colors(2, i), colors(1, i), colors(0, i), 1);
      });
    }
  }

  cv::Mat finish(const Eigen::Vector3f& background) const {
    cv::Mat3f mean(sum_.rows, sum_.cols);
    for (int row = 0; row < sum_.rows; ++row) {
      for (int col = 0; col < sum_.cols; ++col) {
        const cv::Vec4f& s = sum_(row, col);
        mean(row, col) =
            s[3] > 0 ? cv::Vec3f(s[0], s[1], s[2]) / s[3] : cv::Vec3f(background[2], background[1], background[0]);
      }
    }
    cv::Mat small, bytes;
    cv::resize(mean, small, {}, 1.0 / kSupersampling, 1.0 / kSupersampling, cv::INTER_AREA);
    small.convertTo(bytes, CV_8U);
    return bytes;
  }

 private:
  /// A radius of 0 where the point is not in front of the camera.
  Disc project(const Eigen::Vector3f& point) const {
    const Eigen::Vector3f p = camera_from_map_ * point;
    if (!(p.z() > kNear)) return {0, 0, 0, 0};
    const float scale = focal_ / p.z();
    const auto center = [scale](float x, int size) { return x * scale + 0.5F * static_cast<float>(size - 1); };
    return {center(p.x(), depth_.cols), center(p.y(), depth_.rows), p.z(),
            std::clamp(0.5F * size_ * scale, 0.8F, kMaxRadius)};
  }

  /// visit(row, col, closeness), closeness from 1 in the centre to 0 at the rim.
  template <class Visit>
  void forEachPixel(const Disc& disc, const Visit& visit) const {
    const float r = disc.radius;
    if (r <= 0 || disc.u + r < 0 || disc.v + r < 0 || disc.u - r > static_cast<float>(depth_.cols) ||
        disc.v - r > static_cast<float>(depth_.rows)) {
      return;
    }
    const int first_row = std::max(0, static_cast<int>(std::ceil(disc.v - r)));
    const int last_row = std::min(depth_.rows - 1, static_cast<int>(std::floor(disc.v + r)));
    const int first_col = std::max(0, static_cast<int>(std::ceil(disc.u - r)));
    const int last_col = std::min(depth_.cols - 1, static_cast<int>(std::floor(disc.u + r)));
    for (int row = first_row; row <= last_row; ++row) {
      for (int col = first_col; col <= last_col; ++col) {
        const float dx = static_cast<float>(col) - disc.u, dy = static_cast<float>(row) - disc.v;
        const float closeness = 1 - (dx * dx + dy * dy) / (r * r);
        if (closeness >= 0) visit(row, col, closeness);
      }
    }
  }

  Eigen::Isometry3f camera_from_map_;
  cv::Mat1f depth_;
  cv::Mat4f sum_;  // weighted blue, green, red; weight
  float size_, focal_ = 0;
};

}  // namespace

void PictureParams::check() const {
  requireInRange("width", width, 16, 16384);
  requireInRange("height", height, 16, 16384);
  requireInRange("field_of_view", field_of_view, 1.0, 170.0);
  requireInRange("point_size", point_size, 1e-6, 1e6);
}

Eigen::Isometry3d lookAt(const Eigen::Vector3d& eye, const Eigen::Vector3d& target, const Eigen::Vector3d& up) {
  const Eigen::Vector3d forward = target - eye;
  require<std::invalid_argument>(forward.norm() > 1e-9, "eye and target are the same point");
  require<std::invalid_argument>(up.norm() > 1e-9 && up.allFinite(), "the direction up has no length");
  const Eigen::Vector3d z = forward.normalized();
  const bool is_along_up = std::abs(z.dot(up.normalized())) > 0.999;
  Eigen::Index across = 0;
  up.cwiseAbs().minCoeff(&across);
  const Eigen::Vector3d x = z.cross(is_along_up ? Eigen::Vector3d::Unit(across) : up.normalized()).normalized();
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
  pose.linear() << x, z.cross(x), z;
  pose.translation() = eye;
  return pose;
}

cv::Mat drawPicture(const ColoredPoints& points, const Eigen::Isometry3d& map_from_camera,
                    const PictureParams& params) {
  params.check();
  Canvas canvas(map_from_camera, params);
  points([&](PointsRef block, ValuesRef) { canvas.addDepth(block); });
  points([&](PointsRef block, ValuesRef colors) { canvas.addColors(block, colors); });
  return canvas.finish(params.background);
}

Values colorScale(const Eigen::Ref<const Eigen::VectorXf>& numbers, float low, float high) {
  cv::Mat1b ramp(1, 256);
  for (int i = 0; i < 256; ++i) ramp(0, i) = static_cast<std::uint8_t>(i);
  cv::Mat3b map;
  cv::applyColorMap(ramp, map, cv::COLORMAP_VIRIDIS);
  Values colors(3, numbers.size());
  for (Eigen::Index i = 0; i < numbers.size(); ++i) {
    const float t = (numbers[i] - low) / std::max(high - low, 1e-12F);
    if (!(t >= 0)) {
      colors.col(i).setConstant(128);
      continue;
    }
    const cv::Vec3b bgr = map(0, static_cast<int>(255 * std::min(t, 1.F)));
    colors.col(i) << static_cast<float>(bgr[2]), static_cast<float>(bgr[1]), static_cast<float>(bgr[0]);
  }
  return colors;
}

cv::Mat besideEachOther(const std::vector<cv::Mat>& pictures, const std::vector<std::string>& captions) {
  std::vector<cv::Mat> framed;
  for (std::size_t i = 0; i < pictures.size(); ++i) {
    cv::Mat frame;
    cv::copyMakeBorder(pictures[i], frame, 0, 40, i == 0 ? 0 : 6, 0, cv::BORDER_CONSTANT, cv::Scalar::all(255));
    cv::putText(frame, i < captions.size() ? captions[i] : "", {14, frame.rows - 12}, cv::FONT_HERSHEY_SIMPLEX, 0.8,
                cv::Scalar::all(40), 1, cv::LINE_AA);
    framed.push_back(frame);
  }
  cv::Mat all;
  if (!framed.empty()) cv::hconcat(framed, all);
  return all;
}

}  // namespace cloud_colorizer
