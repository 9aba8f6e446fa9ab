// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cmath>
#include <iomanip>
#include <sstream>

#include "alignment/aligner.hpp"
#include "alignment/gains.hpp"
#include "base/robust.hpp"
#include "base/text.hpp"

namespace cloud_colorizer::alignment {

std::string describe(const Evidence& evidence) {
  std::ostringstream text;
  const Improvement &views = evidence.agreement.all, &tie = evidence.tie.all;
  text << std::setprecision(3) << "in " << views.blocks << " blocks held-back points differ by " << views.without
       << " grey levels without it, by " << views.with << " with it (+-" << views.error << ")";
  if (tie.blocks > 0) {
    text << ", the intensity explains " << -100 * tie.without << " and " << -100 * tie.with << " % (+-"
         << 100 * tie.error << ")";
  }
  return text.str() + (evidence.isProven() ? "; kept" : "; left out");
}

std::string refusal(double sigmas, const Evidence& evidence) {
  constexpr double kMaxSigmas = 6;
  std::vector<std::string> reasons;
  if (sigmas > kMaxSigmas) {
    reasons.push_back("its correction would be " + formatFixed(sigmas, 1) + " times what the priors expect");
  }
  if (!evidence.isProven()) reasons.push_back("held-back points do not agree better with its correction");
  return join(reasons, "; ");
}

// Median shift of a view's points between two corrections, in pixels.
double Aligner::pixelsOf(std::size_t view, const PoseState& from, const PoseState& to) const {
  const Camera camera = input_.cameraOf(view);
  const Eigen::Isometry3d a = correctedPose(input_.views[view], from.views[view]).inverse();
  const Eigen::Isometry3d b = correctedPose(input_.views[view], to.views[view]).inverse();
  std::vector<float> shifts;
  const std::size_t stride = std::max<std::size_t>(1, sights_[view].size() / 500);
  for (std::size_t i = 0; i < sights_[view].size(); i += stride) {
    const Eigen::Vector3d point = input_.points.col(sights_[view][i].point).cast<double>();
    const auto pixel_a = camera.linearize(a * point), pixel_b = camera.linearize(b * point);
    if (pixel_a && pixel_b) shifts.push_back(static_cast<float>((pixel_a->pixel - pixel_b->pixel).norm()));
  }
  return median(std::move(shifts));
}

// Of a view, by its camera and its clock.
Twist Aligner::expected(std::size_t view) const {
  const std::uint32_t c = input_.views[view].camera;
  return state_.cameras[c] + state_.time_offsets[c] * priors_.velocities[view];
}

PoseState Aligner::uncorrected() const {
  PoseState state = state_;
  for (auto* twists : {&state.views, &state.cameras}) std::fill(twists->begin(), twists->end(), Twist::Zero());
  std::fill(state.time_offsets.begin(), state.time_offsets.end(), 0);
  return state;
}

// What the views of a camera have in common is the camera's, however the priors would share it out.
void Aligner::shareCommon(const Tracks& tracks) {
  std::vector<Twist> sums(input_.cameras.size(), Twist::Zero());
  std::vector<double> counts(sums.size(), 0);
  for (std::size_t v = 0; v < input_.views.size(); ++v) {
    if (tracks.offsets[v] == tracks.offsets[v + 1]) continue;
    sums[input_.views[v].camera] += state_.views[v] - expected(v);
    ++counts[input_.views[v].camera];
  }
  for (std::size_t c = 0; c < sums.size(); ++c) state_.cameras[c] += sums[c] / std::max(1.0, counts[c]);

  std::vector<double> turns(sums.size(), 0), shifts(sums.size(), 0);  // sums of squares
  for (std::size_t v = 0; v < input_.views.size(); ++v) {
    if (tracks.offsets[v] == tracks.offsets[v + 1]) continue;
    const Twist own = state_.views[v] - expected(v);
    turns[cameraOf(v)] += own.head<3>().squaredNorm();
    shifts[cameraOf(v)] += own.tail<3>().squaredNorm();
  }
  for (std::size_t c = 0; c < sums.size(); ++c) {
    const double pairs = counts[c] * (counts[c] - 1);
    if (!(pairs > 0)) continue;
    result_.cameras[c].rotation_error = std::sqrt(turns[c] / pairs) * 180 / M_PI;
    result_.cameras[c].translation_error = std::sqrt(shifts[c] / pairs);
  }
}

// Takes back what held-back points do not prove: first the views' own corrections, then those of clocks and cameras,
// then all together.
void Aligner::keepProven(const BlurredImages& images) {
  std::vector<std::vector<Sight>> sights(sights_.size());
  workers_.forEach(sights.size(), [&](std::size_t v) { sights[v] = seenInBoth(sights_[v], first_sights_[v]); });
  const Tracks tracks = tracksOf(sights, max_points_, true);
  shareCommon(tracks);
  PoseData data = dataOf(images);
  data.tracks = &tracks;
  keepViews(data);
  PoseState without = state_;
  for (std::size_t v = 0; v < without.views.size(); ++v) without.views[v] -= expected(v) - state_.cameras[cameraOf(v)];
  std::fill(without.time_offsets.begin(), without.time_offsets.end(), 0);
  if (params_.align_time_offset) keepByCamera(data, "the clock", without, alignment::show(data, blocks_, without));
  without = state_;
  for (std::size_t v = 0; v < without.views.size(); ++v) without.views[v] -= state_.cameras[cameraOf(v)];
  std::fill(without.cameras.begin(), without.cameras.end(), Twist::Zero());
  keepByCamera(data, "the camera", without, alignment::show(data, blocks_, without));
  judge(data);
  suspectCalibration(data);
}

// A camera's part of the state becomes that of `without` where held-back points do not prove it; `before` is seen
// there. Returns what is seen at the state as it was.
Showing Aligner::keepByCamera(const PoseData& data, const std::string& what, const PoseState& without,
                              const Showing& before) {
  Showing after = alignment::show(data, blocks_, state_);
  std::vector<Evidence> proof(input_.cameras.size());
  workers_.forEach(proof.size(), [&](std::size_t c) {
    const Choice choice = Choice::ofCamera(static_cast<std::uint32_t>(c), input_.views);
    proof[c] = evidence(*data.tracks, blocks_, before, after, choice);
  });
  for (std::size_t c = 0; c < proof.size(); ++c) {
    log("Alignment of camera_" + std::to_string(c) + ", correction of " + what + ": " + describe(proof[c]));
    if (proof[c].isProven()) continue;
    state_.cameras[c] = without.cameras[c];
    state_.time_offsets[c] = without.time_offsets[c];
  }
  for (std::size_t v = 0; v < without.views.size(); ++v) {
    if (!proof[cameraOf(v)].isProven()) state_.views[v] = without.views[v];
  }
  return after;
}

// Those of all views of a camera together, and then of each.
void Aligner::keepViews(const PoseData& data) {
  PoseState without = state_;
  for (std::size_t v = 0; v < without.views.size(); ++v) without.views[v] = expected(v);
  const Showing before = alignment::show(data, blocks_, without);
  const Showing after = keepByCamera(data, "its views", without, before);
  workers_.forEach(without.views.size(), [&](std::size_t v) {
    if (state_.views[v] == without.views[v]) return;
    const double sigmas =
        (state_.views[v] - without.views[v]).cwiseQuotient(priors_.view_sigmas[v]).cwiseAbs().maxCoeff();
    ViewAlignment& view = result_.views[v];
    Evidence proof = evidence(*data.tracks, blocks_, before, after, Choice::ofView(v, without.views.size()));
    proof.has_halves = false;  // that both halves gain by it is proven for all views together
    view.reason = refusal(sigmas, proof);
    view.refused = !view.reason.empty();
    if (view.refused) state_.views[v] = without.views[v];
  });
}

// All that is kept, against the poses as they came.
void Aligner::judge(const PoseData& data) {
  const std::size_t num_views = input_.views.size();
  const Showing before = alignment::show(data, blocks_, uncorrected()), after = alignment::show(data, blocks_, state_);
  Choice choice = Choice::ofAll(num_views);
  const Evidence all = evidence(*data.tracks, blocks_, before, after, choice);
  result_.residual_before = all.agreement.all.without;
  result_.residual_after = all.agreement.all.with;
  result_.residual_error = all.agreement.all.error;
  result_.corrections_kept = all.isBetter();
  if (!result_.corrections_kept) state_ = uncorrected();
  workers_.forEach(num_views, [&](std::size_t v) {
    const Improvement one =
        evidence(*data.tracks, blocks_, before, after, {choice.without, {v}, Choice::kBoth}).agreement.all;
    result_.views[v].residual_before = one.without;
    result_.views[v].residual_after = result_.corrections_kept ? one.with : one.without;
  });
}

void Aligner::report() {
  const PoseState before = uncorrected();
  std::vector<float> pixels;
  for (std::size_t v = 0; v < input_.views.size(); ++v) {
    ViewAlignment& view = result_.views[v];
    view.map_from_camera = correctedPose(input_.views[v], state_.views[v]);
    view.rotation = state_.views[v].head<3>().norm() * 180 / M_PI;
    view.translation = state_.views[v].tail<3>().norm();
    view.pixels = pixelsOf(v, before, state_);
    if (view.num_points > 0) pixels.push_back(static_cast<float>(view.pixels));
  }
  result_.pixels = median(std::move(pixels));
  for (std::size_t c = 0; c < input_.cameras.size(); ++c) {
    result_.cameras[c].corrected_from_camera = motion(state_.cameras[c]);
    result_.cameras[c].rotation = state_.cameras[c].head<3>().norm() * 180 / M_PI;
    result_.cameras[c].translation = state_.cameras[c].tail<3>().norm();
    if (params_.align_time_offset) result_.cameras[c].time_offset = state_.time_offsets[c];
    warnAboutCamera(static_cast<std::uint32_t>(c));
  }
}

}  // namespace cloud_colorizer::alignment
