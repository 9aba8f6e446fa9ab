// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause
#include "cloud_colorizer/visibility/observe.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "cloud_colorizer/base/check.hpp"
#include "surface/point_runs.hpp"
#include "visibility/best_views.hpp"
#include "visibility/bilinear.hpp"

namespace cloud_colorizer {
namespace {

constexpr float kSaturatedWeight = 0.05F;  // the true value is unknown, only that it is brighter
constexpr auto kBorder = static_cast<float>(kImageBorder);
constexpr float kFullWeightBorder = 20;  // px from the usable border to where an observation counts fully

using Sampler = void (*)(const cv::Mat&, float, float, float*);

Sampler samplerOf(const cv::Mat& image, std::uint32_t view) {
  if (image.depth() == CV_8U) return sampleBilinear<std::uint8_t>;
  if (image.depth() == CV_16U) return sampleBilinear<std::uint16_t>;
  require<std::invalid_argument>(image.depth() == CV_32F, "image of view ", view,
                                 " has an element type other than CV_8U, CV_16U and CV_32F");
  return sampleBilinear<float>;
}

/// Nearly the largest value of the type: demosaicing and JPEG blur the limit. Floats have none.
float saturationOf(const cv::Mat& image) {
  constexpr float kShare = 0.98F;
  if (image.depth() == CV_32F) return std::numeric_limits<float>::infinity();
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
        sampler_(samplerOf(*view.image, view.id)),
        saturation_(saturationOf(*view.image)),
        max_distance_(static_cast<float>(depth_params.max_view_distance)),
        right_(static_cast<float>(camera_.intrinsics().width - 1)),
        bottom_(static_cast<float>(camera_.intrinsics().height - 1)),
        values_(static_cast<std::size_t>(view.image->channels())) {
    const Eigen::Isometry3f camera_from_map = view.map_from_camera.inverse().cast<float>();
    rotation_ = camera_from_map.linear();
    translation_ = camera_from_map.translation();
  }

  void look(PointsRef points, const Surfels& surfels, const std::vector<PointRun>& runs, BestViews& best,
            ObserveResult& result) {
    for (const PointRun& run : runs) {
      if (camera_.mayShow(rotation_ * run.center + translation_, run.radius)) {
        look(points, surfels, run, best, result);
      } else {
        result.stats.outside += static_cast<std::uint64_t>(run.end - run.begin);
      }
    }
  }

 private:
  void look(PointsRef points, const Surfels& surfels, const PointRun& run, BestViews& best, ObserveResult& result) {
    ObserveStats& stats = result.stats;
    for (Eigen::Index i = run.begin; i < run.end; ++i) {
      const Eigen::Vector3f point = rotation_ * surfels.onSurface(i, points.col(i)) + translation_;
      if (!camera_.mayShow(point, 0)) {
        ++stats.outside;
      } else if (!(point.squaredNorm() <= max_distance_ * max_distance_)) {
        ++stats.too_far;
        came(result.unseen[static_cast<std::size_t>(i)], Unseen::kTooFar);
      } else {
        came(result.unseen[static_cast<std::size_t>(i)],
             lookAt(static_cast<std::size_t>(i), point, surfels, best, stats));
      }
    }
  }

  /// A point is told apart by the view that came nearest to colouring it.
  static void came(Unseen& so_far, Unseen now) { so_far = std::min(so_far, now); }

  Unseen lookAt(std::size_t i, const Eigen::Vector3f& point, const Surfels& surfels, BestViews& best,
                ObserveStats& stats) {
    const auto pixel = camera_.project(point);
    const float margin = pixel ? std::min({pixel->x(), pixel->y(), right_ - pixel->x(), bottom_ - pixel->y()}) : -1;
    if (!pixel || margin < kBorder) {
      ++stats.outside;
      return Unseen::kOutside;
    }
    const auto at = static_cast<Eigen::Index>(i);
    const Eigen::Vector3f normal = rotation_ * surfels.normals.col(at);
    const float radius = surfels.radii[at];
    const Visibility visibility =
        view_.depth->test(*pixel, point, normal, radius, depth_params_, surfels.thickness(at));
    if (visibility == Visibility::kHidden) {
      ++stats.hidden;
      best.markHidden(i);
      return Unseen::kHidden;
    }
    if (visibility == Visibility::kAbsent) {
      ++stats.absent;
      return Unseen::kAbsent;
    }
    if (!take(*pixel)) {
      ++stats.masked;
      return Unseen::kMasked;
    }
    const bool edge = visibility == Visibility::kEdge;
    ++(edge ? stats.edge : stats.seen);
    const float distance = point.norm();
    float quality = view_.weight * weight(point, normal, radius, distance, margin);
    if (saturated_) quality *= kSaturatedWeight;
    best.add(i, {view_.id, distance, quality}, values_.data(), edge);
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
    const float footprint = view_.depth->pixel_angle * distance;
    const float sharp = 1 / (1 + std::min(1e6F, footprint * footprint / std::max(1e-12F, radius * radius)));
    const float cosine = normal.isZero() ? 0.5F : std::abs(normal.dot(point)) / std::max(1e-9F, distance);
    const float inside = std::min(1.0F, (margin - kBorder + 1) / kFullWeightBorder);
    return sharp * (0.1F + 0.9F * std::min(1.0F, cosine)) * inside;
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
  const std::vector<PointRun> runs = makeRuns(points, surfels);
  int channels = 0;
  for (std::size_t k = 0; k < num_views; ++k) {
    const ObservedView at = view(k);
    if (k == 0 && at.image) channels = at.image->channels();
    checkView(at, channels);
    if (k == 0) best.reserve(num_views, channels);
    Looker(at, depth_params).look(points, surfels, runs, best, result);
  }
  result.observations = best.finish();
  for (std::size_t p = 0; p < result.unseen.size(); ++p) {
    const bool seen = result.observations.offsets[p + 1] > result.observations.offsets[p];
    if (!seen && result.unseen[p] == Unseen::kSeen) result.unseen[p] = Unseen::kHidden;
  }
  return result;
}

}  // namespace cloud_colorizer
