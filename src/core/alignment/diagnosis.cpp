// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cmath>
#include <iomanip>
#include <sstream>

#include "alignment/aligner.hpp"
#include "base/robust.hpp"

namespace cloud_colorizer::alignment {
namespace {

constexpr double kNearlyAll = 0.7;  // of what a whole correction does

}  // namespace

// The clocks are always looked at, because they are the commonest fault; they are corrected only if asked for.
void Aligner::findClocks() {
  const BlurredImages images(input_, images_, startBlur());
  const PoseData data = dataOf(images);
  updateGains(data);
  PosePriors free = priors_;
  free.time_sigmas.assign(input_.cameras.size(), params_.time_offset_prior);
  const double common = searchTimeOffset(data, free, state_, result_.clock_trials);
  PoseState state = state_, clocks = state_;
  for (double& offset : state.time_offsets) offset = common;
  for (std::size_t v = 0; v < state.views.size(); ++v) state.views[v] += common * priors_.velocities[v];
  const PoseRounds rounds = refinePoses(data, free, state);
  for (std::size_t c = 0; c < input_.cameras.size(); ++c) {
    CameraAlignment& camera = result_.cameras[c];
    if (rounds.time_stddevs[c] > 0.9 * params_.time_offset_prior) continue;  // nothing moves
    camera.time_offset = clocks.time_offsets[c] = state.time_offsets[c];
    camera.time_offset_stddev = rounds.time_stddevs[c];
  }
  for (std::size_t v = 0; v < state.views.size(); ++v) {
    clocks.views[v] += clocks.time_offsets[input_.views[v].camera] * priors_.velocities[v];
  }
  suspectClocks(data, clocks, state);
  if (params_.align_time_offset) state_ = state;
}

// A clock is to blame where it alone explains what held-back points show, and better than the camera's place does.
void Aligner::suspectClocks(const PoseData& data, const PoseState& clocks, const PoseState& all) {
  constexpr double kSuspect = 0.01;  // s: less does not matter
  const auto matters = [](double offset) { return std::abs(offset) > kSuspect; };
  if (std::none_of(clocks.time_offsets.begin(), clocks.time_offsets.end(), matters)) return;
  PosePriors right = priors_;
  for (double& sigma : right.time_sigmas) sigma = 1e-4 * params_.time_offset_prior;
  PoseState places = state_;
  refinePoses(data, right, places);
  for (std::size_t v = 0; v < places.views.size(); ++v) places.views[v] = places.cameras[input_.views[v].camera];

  const Tracks tracks = tracksOf(sights_, fewPoints(), true);
  PoseData proof = data;
  proof.tracks = &tracks;
  const Showing shown[] = {alignment::show(proof, blocks_, state_), alignment::show(proof, blocks_, clocks),
                           alignment::show(proof, blocks_, all)};
  const Showing other = alignment::show(proof, blocks_, places);
  for (std::uint32_t c = 0; c < input_.cameras.size(); ++c) {
    const Choice choice = Choice::ofCamera(c, input_.views);
    result_.cameras[c].time_offset_suspect = matters(clocks.time_offsets[c]) && explains(proof, shown, c, kNearlyAll) &&
                                             evidence(tracks, blocks_, other, shown[1], choice).isProven();
  }
}

// Whether a part of a correction does a share of what the whole does, early and late, at the left and at the right.
// `shown`: without, with the part, with the whole.
bool Aligner::explains(const PoseData& data, const Showing (&shown)[3], std::uint32_t camera, double share) const {
  const Choice all = Choice::ofCamera(camera, input_.views);
  if (!evidence(*data.tracks, blocks_, shown[0], shown[1], all).isProven()) return false;
  std::vector<std::size_t> by_time = all.counted;
  std::stable_sort(by_time.begin(), by_time.end(),
                   [&](auto a, auto b) { return input_.views[a].stamp < input_.views[b].stamp; });
  const auto middle = by_time.begin() + static_cast<std::ptrdiff_t>((by_time.size() + 1) / 2);
  for (const bool late : {false, true}) {
    for (const Choice::Half half : {Choice::kLeft, Choice::kRight}) {
      const Choice choice{
          all.without,
          late ? std::vector<std::size_t>(middle, by_time.end()) : std::vector<std::size_t>(by_time.begin(), middle),
          half};
      const Evidence part = evidence(*data.tracks, blocks_, shown[0], shown[1], choice);
      const Evidence whole = evidence(*data.tracks, blocks_, shown[0], shown[2], choice);
      if (!part.isBetter() || part.main().mean() < share * whole.main().mean()) return false;
    }
  }
  return true;
}

// A correction of the camera explains its images where it does nearly all that the whole correction does, or helps
// everywhere and moves them several times as far as what is left to each view: grey levels do not grow with pixels.
void Aligner::suspectCalibration(const PoseData& data) {
  constexpr double kSeveralTimes = 3;
  PoseState shared = uncorrected();
  for (std::size_t v = 0; v < shared.views.size(); ++v) shared.views[v] = expected(v);
  const Showing shown[] = {alignment::show(data, blocks_, uncorrected()), alignment::show(data, blocks_, shared),
                           alignment::show(data, blocks_, state_)};
  for (std::uint32_t c = 0; c < input_.cameras.size(); ++c) {
    const bool dominates = medianShift(c, uncorrected(), shared) > kSeveralTimes * medianShift(c, shared, state_);
    result_.cameras[c].calibration_suspect = explains(data, shown, c, dominates ? 0 : kNearlyAll);
  }
}

// Over the views of a camera, px.
double Aligner::medianShift(std::uint32_t camera, const PoseState& from, const PoseState& to) const {
  std::vector<float> shifts;
  for (std::size_t v = 0; v < input_.views.size(); ++v) {
    if (cameraOf(v) == camera) shifts.push_back(static_cast<float>(pixelsOf(v, from, to)));
  }
  return median(std::move(shifts));
}

// Says no more than the evidence can tell apart.
void Aligner::warnAboutCamera(std::uint32_t c) {
  const CameraAlignment& camera = result_.cameras[c];
  const double shift = medianShift(c, uncorrected(), state_);
  const double degrees = std::atan(shift / input_.cameras[c].intrinsics().fx) * 180 / M_PI;
  std::ostringstream text;
  text << std::fixed << std::setprecision(3) << "camera_" << c << ": ";
  if (camera.time_offset_suspect) {
    text << "its images agree best at " << std::showpos << camera.time_offset << std::noshowpos << " s"
         << (params_.align_time_offset ? " (corrected)." : "; set the camera's time offset, or align_time_offset.");
  } else if (camera.calibration_suspect && camera.rotation > 2 * params_.extrinsic_rotation_prior) {
    text << "its extrinsic calibration looks wrong by " << camera.rotation
         << " deg: this one correction explains its images at all moments and places.";
  } else if (degrees > 2 * params_.extrinsic_rotation_prior) {
    text << std::setprecision(1) << "the poses or the map differ from its images by " << shift
         << " px (median); no single correction of the camera explains it. Thickness of the map: "
         << 100 * result_.thickness << " cm.";
  } else {
    return;
  }
  result_.warnings.push_back(text.str());
}

}  // namespace cloud_colorizer::alignment
