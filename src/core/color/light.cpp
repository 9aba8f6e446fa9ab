// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause
#include "color/light.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "base/position_hash.hpp"

namespace cloud_colorizer {
namespace {

using Eigen::Index;
using Eigen::Vector3f;

constexpr std::size_t kSearchPoints = 500, kRefinedPoints = 2000;  // of the search, and to be exact
constexpr int kDirections = 200;
constexpr std::array<float, 3> kSharpness = {8, 40, 200};
constexpr float kFirstStep = 0.15F, kLastStep = 0.004F;  // rad
constexpr float kLobeRatio = 2.5F;

/// Evenly over the sphere.
Vector3f onSphere(int i) {
  constexpr float kGoldenAngle = 2.39996F;
  const float z = 1 - (2 * static_cast<float>(i) + 1) / kDirections, r = std::sqrt(1 - z * z);
  const float angle = kGoldenAngle * static_cast<float>(i);
  return {r * std::cos(angle), r * std::sin(angle), z};
}

/// n h of a view in direction d and a light in direction l, from n d.
float halfWay(const Vector3f& normal, float normal_view, const Vector3f& to_view, const Vector3f& light) {
  const float twice = 2 + 2 * to_view.dot(light);  // |d + l|^2
  return twice > 1e-6F ? (normal_view + normal.dot(light)) / std::sqrt(twice) : 0;
}

/// Observations of some points, brightness less the mean of their point.
class SheenSample {
 public:
  SheenSample(const Sights& sights, std::size_t num_points) {
    std::vector<Index> seen;
    for (Index p = 0; p < sights.points.cols(); ++p) {
      if (sights.end(p) - sights.begin(p) >= 3 && !sights.normals.col(p).isZero()) seen.push_back(p);
    }
    const double share = static_cast<double>(num_points) / static_cast<double>(std::max<std::size_t>(1, seen.size()));
    for (const Index p : seen) {
      if (unitHash(sights.points.col(p)) < share) add(sights, p);
    }
  }

  /// How much of the sum of squares a sheen of one strength takes away.
  double explained(const Light& light) const {
    double with_sheen = 0, of_sheen = 0;
    for (const Point& point : points_) {
      sheen_.clear();
      float mean = 0;
      for (std::size_t k = point.first; k < point.last; ++k) {
        const View& view = views_[k];
        const float h = halfWay(point.normal, view.normal_view, view.to_view, light.direction);
        sheen_.push_back(std::exp(light.sharpness * (h - 1)));
        mean += view.weight * sheen_.back();
      }
      mean /= point.weight;
      for (std::size_t k = point.first; k < point.last; ++k) {
        const View& view = views_[k];
        const float sheen = sheen_[k - point.first] - mean;
        with_sheen += view.weight * sheen * view.brightness;
        of_sheen += view.weight * sheen * sheen;
      }
    }
    // A sheen that hardly any view sees explains nothing, however well it fits.
    return with_sheen > 0 ? with_sheen * with_sheen / (of_sheen + 1e-6 * weight_) : 0;
  }

 private:
  struct View {
    Vector3f to_view;
    float normal_view, weight, brightness;
  };
  struct Point {
    Vector3f normal;
    std::size_t first, last;
    float weight;
  };

  void add(const Sights& sights, Index p) {
    Point point{sights.facingNormal(p), views_.size(), 0, 0};
    float mean = 0;
    for (std::uint32_t k = sights.begin(p); k < sights.end(p); ++k) {
      const Vector3f to_view = sights.toView(p, k);
      const float weight = sights.observations.weights[k];
      views_.push_back({to_view, point.normal.dot(to_view), weight, sights.observations.values.col(k).mean()});
      point.weight += weight;
      mean += weight * views_.back().brightness;
    }
    point.last = views_.size();
    if (!(point.weight > 0)) return;
    for (std::size_t k = point.first; k < point.last; ++k) views_[k].brightness -= mean / point.weight;
    weight_ += static_cast<double>(point.weight);
    points_.push_back(point);
  }

  std::vector<View> views_;
  std::vector<Point> points_;
  double weight_ = 0;
  mutable std::vector<float> sheen_;
};

/// Tries what is beside, and goes nearer where nothing there is better.
Light refined(const SheenSample& sample, Light best) {
  double most = sample.explained(best);
  for (float step = kFirstStep; step > kLastStep;) {
    const Vector3f across = best.direction.unitOrthogonal(), up = best.direction.cross(across);
    Light better = best;
    for (const Vector3f& side : {across, Vector3f(-across), up, Vector3f(-up), Vector3f(Vector3f::Zero())}) {
      for (const float factor : {1.F, 1 + step, 1 / (1 + step)}) {
        const Light tried{(best.direction + step * side).normalized(), best.sharpness * factor};
        const double explained = sample.explained(tried);
        if (explained > most) most = explained, better = tried;
      }
    }
    if (better.direction == best.direction && better.sharpness == best.sharpness) step /= 2;
    best = better;
  }
  return best;
}

}  // namespace

Vector3f Sights::facingNormal(Index point) const {
  float side = 0;
  const Vector3f normal = normals.col(point);
  for (std::uint32_t k = begin(point); k < end(point); ++k) side += normal.dot(toView(point, k));
  return side < 0 ? Vector3f(-normal) : normal;
}

Light findLight(const Sights& sights) {
  const SheenSample few(sights, kSearchPoints);
  Light best;
  double most = 0;
  for (const float sharpness : kSharpness) {
    for (int i = 0; i < kDirections; ++i) {
      const Light tried{onSphere(i), sharpness};
      const double explained = few.explained(tried);
      if (explained > most) most = explained, best = tried;
    }
  }
  return most > 0 ? refined(SheenSample(sights, kRefinedPoints), best) : Light();
}

AppearanceBasis::Functions AppearanceBasis::at(const Vector3f& normal, const Vector3f& to_view) const {
  Functions f = Functions::Zero();
  const float normal_view = normal.dot(to_view);
  const Vector3f r = 2 * normal_view * normal - to_view;
  const float x = r.x(), y = r.y(), z = r.z();
  f.head<3>() = 0.488603F * Vector3f(y, z, x);
  if (degree_ > 1) {
    f.segment<5>(3) << 1.092548F * x * y, 1.092548F * y * z, 0.315392F * (3 * z * z - 1), 1.092548F * x * z,
        0.546274F * (x * x - y * y);
  }
  if (light_.sharpness == 0) return f;
  const float h = halfWay(normal, normal_view, to_view, light_.direction) - 1;
  f.tail<kLobes>() << std::exp(light_.sharpness / kLobeRatio * h), std::exp(light_.sharpness * h),
      std::exp(light_.sharpness * kLobeRatio * h);
  return f;
}

}  // namespace cloud_colorizer
