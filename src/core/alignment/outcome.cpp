// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cmath>
#include <iomanip>
#include <sstream>

#include "alignment/aligner.hpp"
#include "alignment/gains.hpp"
#include "alignment/significance.hpp"
#include "base/robust.hpp"
#include "base/text.hpp"

namespace cloud_colorizer::alignment {

std::string refusal(double sigmas, float residual_before, float residual_after) {
  constexpr double kMaxSigmas = 6;
  std::vector<std::string> reasons;
  if (sigmas > kMaxSigmas) {
    reasons.push_back("its correction would be " + formatFixed(sigmas, 1) + " times what the priors expect");
  }
  if (residual_after > 1.05F * residual_before + 0.5F) reasons.push_back("it would agree worse than before");
  return join(reasons, "; ");
}

// Median shift of a view's points between two corrections, in pixels.
double Aligner::pixelsOf(std::size_t view, const PoseState& from) const {
  const Camera& camera = input_.cameras[input_.views[view].camera];
  const Eigen::Isometry3d a = correctedPose(input_.views[view], from.views[view]).inverse();
  const Eigen::Isometry3d b = correctedPose(input_.views[view], state_.views[view]).inverse();
  std::vector<float> shifts;
  const std::size_t stride = std::max<std::size_t>(1, sights_[view].size() / 500);
  for (std::size_t i = 0; i < sights_[view].size(); i += stride) {
    const Eigen::Vector3d point = input_.points.col(sights_[view][i].point).cast<double>();
    const auto pixel_a = camera.linearize(a * point), pixel_b = camera.linearize(b * point);
    if (pixel_a && pixel_b) shifts.push_back(static_cast<float>((pixel_a->pixel - pixel_b->pixel).norm()));
  }
  return median(std::move(shifts));
}

// Corrections that are no larger than their uncertainty are left out.
void Aligner::shrink(const PoseData& data) {
  const PoseShrinkage shrinkage = shrinkPoses(data, priors_, state_);
  for (std::size_t c = 0; c < input_.cameras.size(); ++c) {
    const Shrinkage &common = shrinkage.cameras[c], &views = shrinkage.views[c];
    result_.cameras[c].uncertainty = common.uncertainty;
    result_.cameras[c].views_uncertainty = views.uncertainty;
    if (common.factor > 0 && views.factor > 0) continue;
    std::ostringstream text;
    text << std::setprecision(2) << "Alignment of camera_" << c << ": corrections no larger than their uncertainty are"
         << " left out (";
    if (common.factor == 0) text << "of the camera: " << common.pixels << " +- " << common.uncertainty << " px";
    if (common.factor == 0 && views.factor == 0) text << ", ";
    if (views.factor == 0) text << "of its views: " << views.pixels << " +- " << views.uncertainty << " px";
    log(text.str() + ")");
  }
}

PoseState Aligner::uncorrectedViews() const {
  PoseState state = state_;
  std::fill(state.views.begin(), state.views.end(), Twist::Zero());
  return state;
}

// Median distance of each view's observations to their points' medians, and of all.
std::vector<float> Aligner::residuals(const PoseState& state, std::vector<float>& by_view) const {
  const BlurredImages images(input_, kFinestBlur);
  const SightValues grey = greyValues(dataOf(images), state);
  const std::vector<float> medians = pointMedians(tracks_, grey.values, grey.weights);
  std::vector<float> all;
  by_view.assign(tracks_.numViews(), 0);
  for (std::size_t v = 0; v < tracks_.numViews(); ++v) {
    std::vector<float> own;
    for (std::uint32_t k = tracks_.offsets[v]; k < tracks_.offsets[v + 1]; ++k) {
      const std::uint32_t p = tracks_.sights[k].point;
      if (!(grey.weights[k] > 0) || tracks_.point_offsets[p + 1] - tracks_.point_offsets[p] < 2) continue;
      own.push_back(std::abs(grey.values[k] - medians[p]));
    }
    all.insert(all.end(), own.begin(), own.end());
    by_view[v] = median(std::move(own));
  }
  return all;
}

// A view that went too far, or that agrees worse than before, keeps what its camera tells.
void Aligner::refuse() {
  std::vector<float> first, last;
  result_.residual_before = median(residuals(uncorrectedViews(), first));
  result_.residual_after = median(residuals(state_, last));
  for (std::size_t v = 0; v < input_.views.size(); ++v) {
    ViewAlignment& view = result_.views[v];
    const std::uint32_t c = input_.views[v].camera;
    const Twist expected = state_.cameras[c] + state_.time_offsets[c] * priors_.velocities[v];
    const double sigmas = (state_.views[v] - expected).cwiseQuotient(priors_.view_sigmas[v]).cwiseAbs().maxCoeff();
    view.residual_before = first[v];
    view.residual_after = last[v];
    view.reason = refusal(sigmas, first[v], last[v]);
    if (view.reason.empty()) continue;
    state_.views[v] = expected;
    view.refused = true;
  }
}

void Aligner::warnAboutCamera(std::size_t c) {
  const CameraAlignment& camera = result_.cameras[c];
  std::ostringstream text;
  text << std::fixed << std::setprecision(3);
  if (camera.time_offset_suspect) {
    text << "camera_" << c << ": its images agree best at " << std::showpos << camera.time_offset << std::noshowpos
         << " s";
    text << (params_.align_time_offset ? " (corrected)." : "; set the camera's time offset, or align_time_offset.");
  } else if (camera.rotation > 2 * params_.extrinsic_rotation_prior) {
    text << "camera_" << c << ": its extrinsic calibration looks wrong by " << camera.rotation << " deg.";
  }
  if (!text.str().empty()) result_.warnings.push_back(text.str());
}

void Aligner::report() {
  const PoseState before = uncorrectedViews();
  std::vector<float> pixels;
  for (std::size_t v = 0; v < input_.views.size(); ++v) {
    ViewAlignment& view = result_.views[v];
    view.map_from_camera = correctedPose(input_.views[v], state_.views[v]);
    view.rotation = state_.views[v].head<3>().norm() * 180 / M_PI;
    view.translation = state_.views[v].tail<3>().norm();
    view.pixels = pixelsOf(v, before);
    if (view.num_points > 0) pixels.push_back(static_cast<float>(view.pixels));
  }
  result_.pixels = median(std::move(pixels));
  for (std::size_t c = 0; c < input_.cameras.size(); ++c) {
    result_.cameras[c].corrected_from_camera = motion(state_.cameras[c]);
    result_.cameras[c].rotation = state_.cameras[c].head<3>().norm() * 180 / M_PI;
    result_.cameras[c].translation = state_.cameras[c].tail<3>().norm();
    if (params_.align_time_offset) result_.cameras[c].time_offset = state_.time_offsets[c];
    warnAboutCamera(c);
  }
}

}  // namespace cloud_colorizer::alignment
