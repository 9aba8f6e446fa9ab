// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause

#include <algorithm>
#include <cmath>
#include <numeric>

#include "base/parallel.hpp"
#include "simulation/random.hpp"
#include "simulation/sensors.hpp"

namespace cloud_colorizer::simulation {
namespace {

constexpr int kBlock = 16;      // px; rays of a block share a list of what they may meet
constexpr float kContrast = 9;  // of 255; more than this beside a pixel, and it is sampled more finely
constexpr int kSky = -1;

struct Candidate {
  double nearest;  // m
  int solid;
};

/// Angle of a bounding sphere as seen from the camera, and the direction to it.
struct Bound {
  Eigen::Vector3d direction;
  double angle;    // rad
  double nearest;  // m
};

struct Traced {
  Eigen::Vector3f color{0, 0, 0};
  int surface = kSky;  // solid and face
};

class Renderer {
 public:
  Renderer(const Scene& scene, const PixelRays& rays, const PoseWhileRead& map_from_camera, double time)
      : scene_(scene), rays_(rays), middle_(map_from_camera(0.5)), time_(time) {
    double reach = 0;
    for (int v = 0; v < rays.height(); ++v) {
      rows_.push_back(map_from_camera((v + 0.5) / rays.height()));
      reach = std::max(reach, (rows_.back().translation() - middle_.translation()).norm());
      turn_ = std::max(turn_, Eigen::AngleAxisd(rows_.back().linear().transpose() * middle_.linear()).angle());
    }
    for (const Solid& solid : scene.solids()) {
      const Eigen::Vector3d way = solid.sphereCenter() + solid.offsetAt(time) - middle_.translation();
      const double distance = way.norm();
      const double radius = solid.sphereRadius() + reach;
      const bool is_around = distance <= radius;
      bounds_.push_back({is_around ? Eigen::Vector3d::UnitX() : Eigen::Vector3d(way / distance),
                         is_around ? 10 : std::asin(radius / distance), std::max(0.0, distance - radius)});
    }
  }

  cv::Mat3f render() {
    const int columns = (rays_.width() + kBlock - 1) / kBlock;
    const int rows = (rays_.height() + kBlock - 1) / kBlock;
    cv::Mat3f image(rays_.height(), rays_.width());
    surfaces_.create(rays_.height(), rays_.width());
    std::vector<std::vector<Candidate>> candidates;
    for (int block = 0; block < rows * columns; ++block) {
      const cv::Rect area = areaOf(block % columns, block / columns);
      candidates.push_back(candidatesOf(area));
      forEachPixel(area, [&](int u, int v) {
        const Traced traced = trace(v, rays_.bearing(u, v), candidates.back());
        image(v, u) = cv::Vec3f(traced.color.x(), traced.color.y(), traced.color.z());
        surfaces_(v, u) = traced.surface;
      });
    }
    cv::Mat3f smooth = image.clone();
    for (int block = 0; block < rows * columns; ++block) {
      forEachPixel(areaOf(block % columns, block / columns), [&](int u, int v) {
        if (isEdge(image, u, v)) smooth(v, u) = refine(u, v, candidates[static_cast<std::size_t>(block)]);
      });
    }
    return smooth;
  }

 private:
  cv::Rect areaOf(int column, int row) const {
    return cv::Rect(column * kBlock, row * kBlock, kBlock, kBlock) & cv::Rect(0, 0, rays_.width(), rays_.height());
  }

  template <class F>
  static void forEachPixel(const cv::Rect& area, F&& f) {
    for (int v = area.y; v < area.y + area.height; ++v) {
      for (int u = area.x; u < area.x + area.width; ++u) f(u, v);
    }
  }

  /// All solids whose bounding sphere the cone around the block's rays touches, nearest first.
  std::vector<Candidate> candidatesOf(const cv::Rect& area) const {
    Eigen::Vector3f sum(0, 0, 0);
    forEachPixel(area, [&](int u, int v) { sum += rays_.bearing(u, v); });
    if (sum.isZero()) return {};
    const Eigen::Vector3f axis = sum.normalized();
    float cosine = 1;
    forEachPixel(area, [&](int u, int v) {
      if (!rays_.bearing(u, v).isZero()) cosine = std::min(cosine, axis.dot(rays_.bearing(u, v)));
    });
    const double half_angle =
        std::acos(static_cast<double>(cosine)) + 2 * static_cast<double>(rays_.pixelAngle()) + turn_;
    const Eigen::Vector3d direction = middle_.linear() * axis.cast<double>();
    std::vector<Candidate> found;
    for (std::size_t i = 0; i < bounds_.size(); ++i) {
      const Bound& bound = bounds_[i];
      if (bound.direction.dot(direction) < std::cos(std::min(3.1415926, bound.angle + half_angle))) continue;
      found.push_back({bound.nearest, static_cast<int>(i)});
    }
    std::sort(found.begin(), found.end(), [](const Candidate& a, const Candidate& b) {
      return a.nearest < b.nearest || (a.nearest == b.nearest && a.solid < b.solid);
    });
    return found;
  }

  Traced trace(int row, const Eigen::Vector3f& bearing, const std::vector<Candidate>& candidates) const {
    Traced traced;
    if (bearing.isZero()) return traced;
    const Eigen::Isometry3d& pose = rows_[static_cast<std::size_t>(row)];
    const Eigen::Vector3d direction = (pose.linear() * bearing.cast<double>()).normalized();
    LocalHit best;
    LocalHit hit;
    int solid = -1;
    best.distance = std::numeric_limits<double>::infinity();
    for (const Candidate& candidate : candidates) {
      if (candidate.nearest >= best.distance) break;
      const Solid& tested = scene_.solids()[static_cast<std::size_t>(candidate.solid)];
      if (!tested.intersect(pose.translation(), direction, time_, best.distance, hit)) continue;
      best = hit;
      solid = candidate.solid;
    }
    if (solid < 0) {
      traced.color = scene_.skyColor(direction).matrix();
      return traced;
    }
    const Hit complete = scene_.completeHit(solid, best, time_);
    const double cosine = std::max(0.05, -complete.normal.dot(direction));
    const auto footprint = static_cast<float>(best.distance / std::sqrt(cosine)) * rays_.pixelAngle();
    traced.color = scene_.trueColor(complete, std::max(0.002F, footprint)).matrix();
    traced.color.array() += scene_.sheen(complete, direction);
    traced.surface = solid * 16 + best.face;
    return traced;
  }

  bool isEdge(const cv::Mat3f& image, int u, int v) const {
    const cv::Vec3f& here = image(v, u);
    for (int dv = -1; dv <= 1; ++dv) {
      for (int du = -1; du <= 1; ++du) {
        if (u + du < 0 || v + dv < 0 || u + du >= image.cols || v + dv >= image.rows) continue;
        if (surfaces_(v + dv, u + du) != surfaces_(v, u)) return true;
        const cv::Vec3f& there = image(v + dv, u + du);
        for (int c = 0; c < 3; ++c) {
          if (std::abs(there[c] - here[c]) > kContrast) return true;
        }
      }
    }
    return false;
  }

  cv::Vec3f refine(int u, int v, const std::vector<Candidate>& candidates) const {
    // A rotated grid: no two samples share a row or a column.
    constexpr float kGrid[4][2] = {{-0.125F, -0.375F}, {0.375F, -0.125F}, {-0.375F, 0.125F}, {0.125F, 0.375F}};
    Eigen::Vector3f sum(0, 0, 0);
    for (const auto& offset : kGrid) {
      sum += trace(v, rays_.bearingBeside(u, v, offset[0], offset[1]), candidates).color;
    }
    sum /= 4;
    return {sum.x(), sum.y(), sum.z()};
  }

  const Scene& scene_;
  const PixelRays& rays_;
  Eigen::Isometry3d middle_;
  std::vector<Eigen::Isometry3d> rows_;  ///< when each was read
  double turn_ = 0;                      ///< rad, largest from the middle one
  double time_;
  std::vector<Bound> bounds_;
  cv::Mat1i surfaces_;
};

}  // namespace

PixelRays::PixelRays(const Camera& camera, int num_threads)
    : width_(camera.intrinsics().width),
      height_(camera.intrinsics().height),
      pixel_angle_(static_cast<float>(1 / std::min(camera.intrinsics().fx, camera.intrinsics().fy))),
      bearings_(static_cast<std::size_t>(width_) * static_cast<std::size_t>(height_), Eigen::Vector3f::Zero()) {
  const auto exact = [&](int u, int v) {
    const auto bearing = camera.bearing(Eigen::Vector2d(u, v));
    if (bearing) bearings_[index(u, v)] = bearing->cast<float>();
  };
  // Every second pixel is inverted; the mean of its neighbours is as good as 0.001 px for those between.
  const auto between = [&](int u, int v, int du, int dv) {
    const Eigen::Vector3f& a = bearings_[index(u - du, v - dv)];
    const Eigen::Vector3f& b = bearings_[index(u + du, v + dv)];
    if (a.isZero() || b.isZero()) return exact(u, v);
    bearings_[index(u, v)] = (a + b).normalized();
  };
  parallelFor(num_threads, static_cast<std::size_t>((height_ + 1) / 2), [&](std::size_t pair) {
    const int v = 2 * static_cast<int>(pair);
    for (int u = 0; u < width_; u += 2) exact(u, v);
    for (int u = 1; u < width_; u += 2) u + 1 < width_ ? between(u, v, 1, 0) : exact(u, v);
  });
  parallelFor(num_threads, static_cast<std::size_t>(height_ / 2), [&](std::size_t pair) {
    const int v = 2 * static_cast<int>(pair) + 1;
    for (int u = 0; u < width_; ++u) v + 1 < height_ ? between(u, v, 0, 1) : exact(u, v);
  });
}

Eigen::Vector3f PixelRays::bearingBeside(int u, int v, float du, float dv) const {
  const auto step = [](const Eigen::Vector3f& low, const Eigen::Vector3f& high, int pixels) -> Eigen::Vector3f {
    if (low.isZero() || high.isZero() || pixels == 0) return Eigen::Vector3f::Zero();
    return (high - low) / static_cast<float>(pixels);
  };
  const int left = std::max(0, u - 1);
  const int right = std::min(width_ - 1, u + 1);
  const int upper = std::max(0, v - 1);
  const int lower = std::min(height_ - 1, v + 1);
  return bearing(u, v) + du * step(bearing(left, v), bearing(right, v), right - left) +
         dv * step(bearing(u, upper), bearing(u, lower), lower - upper);
}

cv::Mat3f renderImage(const Scene& scene, const PixelRays& rays, const PoseWhileRead& map_from_camera, double time) {
  return Renderer(scene, rays, map_from_camera, time).render();
}

cv::Mat3b exposeImage(const cv::Mat3f& image, const Color& gain, double vignetting, double noise, std::uint64_t key) {
  cv::Mat3b exposed(image.size());
  const auto loss = static_cast<float>(vignetting);
  const auto sigma = static_cast<float>(noise);
  const float half_diagonal_squared = 0.25F * static_cast<float>(image.cols * image.cols + image.rows * image.rows);
  for (int v = 0; v < image.rows; ++v) {
    for (int u = 0; u < image.cols; ++u) {
      float triple[3] = {0, 0, 0};
      if (sigma > 0)
        gaussianTriple(key ^ mixBits(static_cast<std::uint64_t>(v) << 32 | static_cast<unsigned>(u)), triple);
      const float x = static_cast<float>(u) - 0.5F * static_cast<float>(image.cols - 1);
      const float y = static_cast<float>(v) - 0.5F * static_cast<float>(image.rows - 1);
      const float shade = 1 - loss * (x * x + y * y) / half_diagonal_squared;
      for (int c = 0; c < 3; ++c) {
        exposed(v, u)[c] = cv::saturate_cast<uchar>(image(v, u)[c] * gain[c] * shade + sigma * triple[c]);
      }
    }
  }
  return exposed;
}

cv::Mat3b takeImage(const Scene& scene, const Drive& drive, const PixelRays& rays, int camera, int frame) {
  const Options& o = drive.options();
  const auto pose = [&](double share) { return drive.mapFromCamera(camera, frame, share); };
  const cv::Mat3f image = renderImage(scene, rays, pose, drive.imageTime(camera, frame));
  return exposeImage(image, drive.gain(camera, frame), o.vignetting, o.pixel_noise, keyOf(o.seed, 60, camera, frame));
}

}  // namespace cloud_colorizer::simulation
