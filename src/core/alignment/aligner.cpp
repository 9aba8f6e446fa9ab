// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause
#include "alignment/aligner.hpp"

#include <algorithm>
#include <cmath>
#include <sstream>

#include "alignment/exposure.hpp"
#include "alignment/gains.hpp"
#include "alignment/intensity.hpp"
#include "base/robust.hpp"

namespace cloud_colorizer::alignment {
namespace {

constexpr double kCoarsestBlur = 8;     // px of the small images: beyond it too little texture is left
constexpr double kBlurRatio = 0.6;      // from one level to the next
constexpr std::size_t kMinShared = 60;  // points that a view must share with others

}  // namespace

Aligner::Aligner(const AlignmentInput& input, double thickness, const AlignmentParams& params,
                 const Callbacks& callbacks)
    : input_(input),
      params_(params),
      workers_(input.num_threads, callbacks),
      runs_(makeRuns(input.surfels.onSurface(input.points), input.surfels)),
      images_(input),
      sights_(input.views.size()) {
  max_points_ = params.pointsPerView(input.views.size());
  state_.views.assign(input.views.size(), Twist::Zero());
  state_.cameras.assign(input.cameras.size(), Twist::Zero());
  state_.time_offsets.assign(input.cameras.size(), 0);
  seen_at_ = state_;
  log_gains_ = Eigen::VectorXd::Zero(static_cast<Eigen::Index>(input.views.size()));
  result_.thickness = thickness;
  result_.views.resize(input.views.size());
  result_.cameras.resize(input.cameras.size());
  for (std::size_t v = 0; v < input.views.size(); ++v) {
    result_.views[v].map_from_camera = input.views[v].map_from_camera;
  }
}

PoseData Aligner::dataOf(const BlurredImages& images) const {
  return {&input_, &tracks_, &images, &log_gains_, &workers_, ranks_.size() > 0 ? &ranks_ : nullptr};
}

void Aligner::show(std::size_t done, std::size_t total) const {
  throwIfCancelled(workers_.callbacks);
  if (workers_.callbacks.progress) workers_.callbacks.progress({"align poses", done, total, 0, -1});
}

void Aligner::log(const std::string& text) const {
  if (workers_.callbacks.log) workers_.callbacks.log(LogLevel::kInfo, text);
}

std::size_t Aligner::fewPoints() const {
  constexpr std::size_t kFewPoints = 4000;  // of a view: enough for all but the last, finest level
  return std::min(max_points_, kFewPoints);
}

// Else says so: what is saturated is known of 8-bit images only.
bool Aligner::hasDepth8Bit() {
  std::vector<bool> seen(input_.cameras.size(), false);
  for (std::size_t v = 0; v < input_.views.size(); ++v) {
    const std::uint32_t camera = input_.views[v].camera;
    if (seen[camera]) continue;
    seen[camera] = true;
    const auto image = input_.images(v);
    if (!image || image->depth() == CV_8U) continue;
    result_.warnings.push_back("Nothing was aligned: the images of camera_" + std::to_string(camera) +
                               " are not 8 bits a channel; convert them, or set align_exposure false and align_poses "
                               "none to be without this warning.");
    return false;
  }
  return true;
}

// Looks again which view sees which point, only in those views that have moved, unless `all`; and makes tracks of at
// most so many points of each view.
void Aligner::look(bool all, std::size_t points) {
  constexpr double kMovedPixels = 1.5;  // of its small image
  workers_.forEach(input_.views.size(), [&](std::size_t v) {
    const int step = smallStep(input_.cameras[cameraOf(v)].intrinsics());
    if (!all && pixelsOf(v, seen_at_, state_) < kMovedPixels * step) return;
    const Eigen::Isometry3d pose = correctedPose(input_.views[v], state_.views[v]);
    sights_[v] = findSights(input_, runs_, v, pose, max_points_);
    seen_at_.views[v] = state_.views[v];
  });
  tracks_ = tracksOf(sights_, points, false);
}

Tracks Aligner::tracksOf(const std::vector<std::vector<Sight>>& sights, std::size_t points, bool with_held_back) const {
  return makeTracks(sights, static_cast<std::size_t>(input_.points.cols()), points,
                    [&](std::uint32_t p) { return with_held_back || !blocks_.isHeldBack(p); });
}

// A twelfth of an image wide, at the median distance.
double Aligner::blockSide(const std::vector<double>& depths) const {
  constexpr double kBlocksAcross = 12;
  std::vector<double> widths;
  for (std::size_t v = 0; v < depths.size(); ++v) {
    const Intrinsics& k = input_.cameras[input_.views[v].camera].intrinsics();
    if (depths[v] > 0) widths.push_back(depths[v] * k.width / k.fx);
  }
  return std::max(1e-9, median(std::move(widths)) / kBlocksAcross);
}

// Of each view, m.
std::vector<double> Aligner::medianDepths() const {
  std::vector<double> medians;
  for (std::size_t v = 0; v < input_.views.size(); ++v) {
    const Eigen::Isometry3d camera_from_map = correctedPose(input_.views[v], state_.views[v]).inverse();
    std::vector<float> depths;
    for (const Sight& s : sights_[v]) {
      depths.push_back(static_cast<float>((camera_from_map * input_.points.col(s.point).cast<double>()).z()));
    }
    medians.push_back(median(std::move(depths)));
  }
  return medians;
}

bool Aligner::hasOverlap() {
  std::size_t usable = 0;
  for (std::size_t v = 0; v < tracks_.numViews(); ++v) {
    std::size_t shared = 0;
    for (const Sight& s : sights_[v]) {
      shared += tracks_.point_offsets[s.point + 1] - tracks_.point_offsets[s.point] >= 2;
    }
    result_.views[v].num_points = shared;
    usable += shared >= kMinShared;
    if (shared >= kMinShared) continue;
    result_.views[v].refused = true;
    result_.views[v].reason = "shares only " + std::to_string(shared) + " sample points with other views";
  }
  if (usable >= 2) return true;
  result_.warnings.push_back("Nothing was aligned: only " + std::to_string(usable) + " of " +
                             std::to_string(input_.views.size()) + " views share " + std::to_string(kMinShared) +
                             " sample points with others.");
  return false;
}

// As many pixels of the small images as the priors let a point be off.
double Aligner::startBlur() const {
  double focal = 0;
  for (const Camera& camera : input_.cameras) {
    focal = std::max(focal, camera.intrinsics().fx / smallStep(camera.intrinsics()));
  }
  double variance = std::pow(params_.extrinsic_rotation_prior * M_PI / 180, 2);
  if (params_.align_poses == AlignPoses::kViews) variance += std::pow(params_.pose_rotation_prior * M_PI / 180, 2);
  return std::clamp(focal * std::sqrt(2 * variance), 2.0, kCoarsestBlur);
}

std::vector<double> Aligner::levels() const {
  std::vector<double> sigmas;
  for (double sigma = startBlur(); sigma > kFinestBlur * 1.2; sigma *= kBlurRatio) sigmas.push_back(sigma);
  sigmas.push_back(kFinestBlur);
  return sigmas;
}

void Aligner::updateGains(PoseData data) {
  const Eigen::VectorXd none = Eigen::VectorXd::Zero(log_gains_.size());
  data.log_gains = &none;
  const SightValues grey = greyValues(data, state_);
  log_gains_ = estimateLogGains(tracks_, grey.values, grey.weights, kMaxGain, workers_);
}

void Aligner::refine() {
  look(false, fewPoints());
  findClocks();
  const std::vector<double> sigmas = levels();
  for (std::size_t level = 0; level < sigmas.size(); ++level) {
    show(level, sigmas.size());
    look(false, level + 1 < sigmas.size() ? fewPoints() : max_points_);
    const BlurredImages images(input_, images_, sigmas[level]);
    const PoseData data = dataOf(images);
    updateGains(data);
    if (level > 0) learnSteps(input_.views, state_, priors_);
    const PoseRounds rounds = refinePoses(data, priors_, state_);
    if (level + 1 == sigmas.size()) keepProven(images);
    std::ostringstream text;
    text << "Alignment at a blur of " << sigmas[level] << " px: residual " << rounds.residual_first << " to "
         << rounds.residual_last << " grey levels in " << rounds.accepted << " steps";
    if (rounds.explained > 0) text << ", intensity explains " << 100 * rounds.explained << " %";
    log(text.str());
  }
  show(sigmas.size(), sigmas.size());
}

AlignmentResult Aligner::run() {
  if (!params_.align_exposure && params_.align_poses == AlignPoses::kNone) return std::move(result_);
  if (!hasDepth8Bit()) return std::move(result_);
  if (params_.align_to_intensity) ranks_ = intensityRanks(input_.intensity);
  look(true, max_points_);
  if (!hasOverlap()) return std::move(result_);
  const std::vector<double> depths = medianDepths();
  priors_ = makePriors(input_, params_, depths);
  blocks_ = makeBlocks(input_.points, blockSide(depths));
  first_sights_ = sights_;
  if (params_.align_poses != AlignPoses::kNone) {
    refine();
    result_.poses_aligned = true;
  }
  look(false, fewPoints());
  const double sigma = result_.poses_aligned ? 1.2 : startBlur();
  const Tracks all = tracksOf(sights_, fewPoints(), true);
  const auto exposures = estimateExposures(input_, all, blocks_, state_, sigma, params_.align_vignetting, workers_);
  const std::vector<float> weights = sharpnessWeights(input_, all, state_, exposures, images_, workers_);
  for (std::size_t v = 0; v < weights.size(); ++v) {
    if (params_.align_exposure) {
      result_.views[v].exposure = exposures[v];
      result_.cameras[input_.views[v].camera].vignetting = exposures[v].vignetting;
    }
    result_.views[v].weight = weights[v];
  }
  result_.exposure_aligned = params_.align_exposure;
  report();
  return std::move(result_);
}

}  // namespace cloud_colorizer::alignment
