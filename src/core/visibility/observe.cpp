// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause
#include "cloud_colorizer/visibility/observe.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "cloud_colorizer/base/check.hpp"
#include "surface/point_runs.hpp"
#include "visibility/best_views.hpp"
#include "visibility/samplers.hpp"

namespace cloud_colorizer {
namespace {

constexpr float kSaturatedWeight = 0.05F;  // the true value is unknown, only that it is brighter
constexpr auto kBorder = static_cast<float>(kImageBorder);
constexpr std::size_t kBeside = 8;  // points before one and after it that are asked what they are to the view,
constexpr float kReach = 4;         // where they are nearer than this many surfel radii;
constexpr float kLeastSupport = 0.2F, kLeastBallSupport = -0.2F;  // their mean, else the point is alone
constexpr float kFullWeightBorder = 20;  // px from the usable border to where an observation counts fully

Sampler samplerOf(const ObservedView& view) {
  const Sampler sampler = samplerOf(view.image->depth(), view.kind);
  require<std::invalid_argument>(sampler != nullptr, "image of view ", view.id,
                                 " has an element type other than CV_8U, CV_16U and CV_32F");
  return sampler;
}

/// Nearly the largest value of the type: demosaicing and JPEG blur the limit. Floats have none.
float saturationOf(const cv::Mat& image, ImageKind kind) {
  constexpr float kShare = 0.98F;
  if (image.depth() == CV_32F || kind != ImageKind::kColor) return std::numeric_limits<float>::infinity();
  return kShare * (image.depth() == CV_8U ? 255.0F : 65535.0F);
}

void checkView(const ObservedView& view, int channels) {
  using Invalid = std::invalid_argument;
  require<Invalid>(view.camera && view.image && view.depth, "view ", view.id,
                   " lacks its camera, image or depth image");
  const auto& size = view.camera->intrinsics();
  const auto check_size = [&](const cv::Mat& image, const char* what) {
    require<Invalid>(image.cols == size.width && image.rows == size.height, what, " of view ", view.id, " is ",
                     image.cols, " x ", image.rows, " px, its camera ", size.width, " x ", size.height);
  };
  check_size(*view.image, "image");
  require<Invalid>(view.image->channels() == channels, "image of view ", view.id, " has ", view.image->channels(),
                   " channels, those before it ", channels);
  for (const auto* factor : {&view.exposure.gain, &view.exposure.offset}) {
    require<Invalid>(factor->size() == 0 || factor->size() == channels, "exposure of view ", view.id, " has ",
                     factor->size(), " channels, its image ", channels);
  }
  require<Invalid>(view.map_from_camera.matrix().allFinite(), "pose of view ", view.id, " is not finite");
  if (!view.mask) return;
  check_size(*view.mask, "mask");
  require<Invalid>(view.mask->type() == CV_8UC1, "mask of view ", view.id, " is not CV_8UC1");
}

/// Looks from one view at all points.
class Looker {
 public:
  Looker(const ObservedView& view, const DepthParams& depth_params)
      : view_(view),
        depth_params_(depth_params),
        camera_(*view.camera),
        sampler_(samplerOf(view)),
        saturation_(saturationOf(*view.image, view.kind)),
        max_distance_(static_cast<float>(depth_params.reach())),
        right_(static_cast<float>(camera_.intrinsics().width - 1)),
        bottom_(static_cast<float>(camera_.intrinsics().height - 1)),
        values_(static_cast<std::size_t>(view.image->channels())) {
    const Eigen::Isometry3f camera_from_map = view.map_from_camera.inverse().cast<float>();
    rotation_ = camera_from_map.linear();
    translation_ = camera_from_map.translation();
  }

  /// `places`: the points, moved onto their surfels.
  void look(PointsRef places, const Surfels& surfels, const std::vector<PointRun>& runs, BestViews& best,
            ObserveResult& result) {
    glances_.clear();
    for (const PointRun& run : runs) {
      const Eigen::Vector3f center = rotation_ * run.center + translation_;
      const auto count = static_cast<std::uint64_t>(run.end - run.begin);
      if (!camera_.mayShow(center, run.radius)) {
        result.stats.outside += count;
      } else if (largestWeight(run, center.norm() - run.radius) <
                 best.leastUseful(static_cast<std::size_t>(run.begin), static_cast<std::size_t>(run.end))) {
        result.stats.worse += count;
      } else {
        look(places, surfels, run, result);
      }
    }
    for (std::size_t g = 0; g < glances_.size(); ++g) {
      const std::size_t i = glances_[g].point;
      came(result.unseen[i], decide(g, surfels, best, result.stats));
    }
  }

 private:
  /// What the view has of a point in its image, before those beside it are asked.
  struct Glance {
    std::uint32_t point;
    Sight sight;
    Eigen::Vector2f pixel;
    Eigen::Vector3f position;  ///< m, in the camera's frame
    float margin;              ///< px, from the image's border
  };

  /// That any point of a run can have, from its smallest distance [m].
  float largestWeight(const PointRun& run, float distance) const {
    return view_.weight * sharpness(run.largest, std::max(0.F, distance));
  }

  void look(PointsRef places, const Surfels& surfels, const PointRun& run, ObserveResult& result) {
    ObserveStats& stats = result.stats;
    for (Eigen::Index i = run.begin; i < run.end; ++i) {
      const Eigen::Vector3f point = rotation_ * places.col(i) + translation_;
      if (!camera_.mayShow(point, 0)) {
        ++stats.outside;
      } else if (!(point.squaredNorm() <= max_distance_ * max_distance_)) {
        ++stats.too_far;
        came(result.unseen[static_cast<std::size_t>(i)], Unseen::kTooFar);
      } else {
        glanceAt(static_cast<std::uint32_t>(i), point, surfels, stats);
      }
    }
  }

  /// A point is told apart by the view that came nearest to colouring it.
  static void came(Unseen& so_far, Unseen now) { so_far = std::min(so_far, now); }

  void glanceAt(std::uint32_t i, const Eigen::Vector3f& point, const Surfels& surfels, ObserveStats& stats) {
    const auto pixel = camera_.project(point);
    const float margin = pixel ? std::min({pixel->x(), pixel->y(), right_ - pixel->x(), bottom_ - pixel->y()}) : -1;
    if (!pixel || margin < kBorder) {
      ++stats.outside;
      return;
    }
    const Eigen::Vector3f normal = rotation_ * surfels.normals.col(i);
    const Sight sight = view_.depth->look(*pixel, point, normal, surfels.radii[i], depth_params_, surfels.thickness(i));
    glances_.push_back({i, sight, *pixel, point, margin});
  }

  /// What is seen of a surface is seen in patches: one point that seems to be in sight among many that are hidden has
  /// slipped through. Of those before and after it, which are near where points are in Z-order.
  bool isAlone(std::size_t g, const Surfels& surfels) const {
    Support support;
    for (std::size_t other = g; other > 0 && support.asked < kBeside; --other)
      ask(g, other - 1, other, surfels, support);
    support.asked = 0;
    for (std::size_t other = g + 1; other < glances_.size() && support.asked < kBeside; ++other) {
      ask(g, other, other - 1, surfels, support);
    }
    return support.sum <
           support.count * (surfels.normals.col(glances_[g].point).isZero() ? kLeastBallSupport : kLeastSupport);
  }

  struct Support {
    std::size_t asked = 0;
    float sum = 0, count = 0;
  };
  /// A place that holds several points is asked once: `before` was the last that was looked at.
  void ask(std::size_t g, std::size_t other, std::size_t before, const Surfels& surfels, Support& support) const {
    const Glance &glance = glances_[g], &beside = glances_[other];
    if (beside.position == glances_[before].position) return;
    ++support.asked;
    const float reach = kReach * std::abs(surfels.radii[glance.point]);
    if (beside.sight.visibility == Visibility::kAbsent) return;
    if (!((beside.position - glance.position).squaredNorm() < reach * reach)) return;
    support.sum += beside.sight.support;
    support.count += 1;
  }

  Unseen decide(std::size_t g, const Surfels& surfels, BestViews& best, ObserveStats& stats) {
    const Glance& glance = glances_[g];
    const float radius = std::abs(surfels.radii[glance.point]);
    if (glance.sight.visibility == Visibility::kAbsent) {
      ++stats.absent;
      return Unseen::kAbsent;
    }
    const auto hide = [&] {
      ++stats.hidden;
      best.markHidden(glance.point);
      return Unseen::kHidden;
    };
    if (glance.sight.visibility == Visibility::kHidden) return hide();
    const Eigen::Vector3f normal = rotation_ * surfels.normals.col(glance.point);
    const float distance = glance.position.norm();
    float quality = view_.weight * weight(glance.position, normal, radius, distance, glance.margin);
    if (best.isSettled(glance.point, quality)) {
      ++stats.worse;
      return Unseen::kSeen;
    }
    if (isAlone(g, surfels)) return hide();
    if (!take(glance.pixel)) {
      ++stats.masked;
      return Unseen::kMasked;
    }
    const bool edge = glance.sight.visibility == Visibility::kEdge;
    ++(edge ? stats.edge : stats.seen);
    if (saturated_) quality *= kSaturatedWeight;
    best.add(glance.point, {view_.id, distance, quality}, values_.data(), edge);
    return Unseen::kSeen;
  }

  /// Reads the values at a pixel; false where the mask or a value that is not finite forbids it.
  bool take(const Eigen::Vector2f& pixel) {
    if (view_.mask && (*view_.mask)
                              .at<std::uint8_t>(static_cast<int>(std::lround(pixel.y())),
                                                static_cast<int>(std::lround(pixel.x()))) == 0) {
      return false;
    }
    sampler_(*view_.image, pixel.x(), pixel.y(), values_.data());
    const auto& size = camera_.intrinsics();
    const float brightening = view_.exposure.brightening(pixel.x(), pixel.y(), static_cast<float>(size.width),
                                                         static_cast<float>(size.height));
    bool finite = true;
    saturated_ = false;
    for (std::size_t c = 0; c < values_.size(); ++c) {
      saturated_ = saturated_ || values_[c] >= saturation_;
      const auto channel = static_cast<Eigen::Index>(c);
      values_[c] *= brightening;
      if (view_.exposure.gain.size() > 0) values_[c] *= view_.exposure.gain[channel];
      if (view_.exposure.offset.size() > 0) values_[c] += view_.exposure.offset[channel];
      finite = finite && std::isfinite(values_[c]);
    }
    return finite;
  }

  /// Falls when a pixel covers more than the point's surroundings, at grazing incidence, and towards the border.
  float weight(const Eigen::Vector3f& point, const Eigen::Vector3f& normal, float radius, float distance,
               float margin) const {
    const float cosine = normal.isZero() ? 0.5F : std::abs(normal.dot(point)) / std::max(1e-9F, distance);
    const float inside = std::min(1.0F, (margin - kBorder + 1) / kFullWeightBorder);
    return sharpness(radius, distance) * (0.1F + 0.9F * std::min(1.0F, cosine)) * inside;
  }

  float sharpness(float radius, float distance) const {
    const float footprint = view_.depth->pixel_angle * distance;
    return 1 / (1 + std::min(1e6F, footprint * footprint / std::max(1e-12F, radius * radius)));
  }

  const ObservedView& view_;
  const DepthParams& depth_params_;
  const Camera& camera_;
  Sampler sampler_;
  float saturation_;  ///< a value from which on it is saturated
  float max_distance_, right_, bottom_;
  bool saturated_ = false;  ///< the values taken last
  Eigen::Matrix3f rotation_;
  Eigen::Vector3f translation_;
  std::vector<float> values_;
  std::vector<Glance> glances_;
};

}  // namespace

void ObserveParams::check() const {
  requireInRange("max_views", max_views, 1, 100000);
}

ObserveResult observe(PointsRef points, const Surfels& surfels, std::size_t num_views,
                      const std::function<ObservedView(std::size_t)>& view, const DepthParams& depth_params,
                      const ObserveParams& params) {
  params.check();
  depth_params.check();
  require<std::invalid_argument>(surfels.normals.cols() == points.cols() && surfels.radii.size() == points.cols(),
                                 "observe: ", surfels.radii.size(), " surfels for ", points.cols(), " points");
  ObserveResult result;
  result.unseen.assign(static_cast<std::size_t>(points.cols()), Unseen::kOutside);
  BestViews best(static_cast<std::size_t>(points.cols()), params.max_views);
  const Points places = surfels.onSurface(points);
  const std::vector<PointRun> runs = makeRuns(places, surfels);
  int channels = 0;
  for (std::size_t k = 0; k < num_views; ++k) {
    const ObservedView at = view(k);
    if (k == 0 && at.image) channels = at.image->channels();
    checkView(at, channels);
    if (k == 0) best.reserve(num_views, channels);
    Looker(at, depth_params).look(places, surfels, runs, best, result);
  }
  result.observations = best.finish();
  for (std::size_t p = 0; p < result.unseen.size(); ++p) {
    const bool seen = result.observations.offsets[p + 1] > result.observations.offsets[p];
    if (!seen && result.unseen[p] == Unseen::kSeen) result.unseen[p] = Unseen::kHidden;
  }
  return result;
}

}  // namespace cloud_colorizer
