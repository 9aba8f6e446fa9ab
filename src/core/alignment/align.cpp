// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause
#include "cloud_colorizer/alignment/align.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <iomanip>
#include <sstream>

#include "alignment/blurred_images.hpp"
#include "alignment/exposure.hpp"
#include "alignment/gains.hpp"
#include "alignment/intensity.hpp"
#include "alignment/poses.hpp"
#include "alignment/significance.hpp"
#include "alignment/tracks.hpp"
#include "base/parallel.hpp"
#include "base/robust.hpp"
#include "cloud_colorizer/base/check.hpp"

namespace cloud_colorizer {
namespace {

using namespace alignment;

constexpr double kFinestBlur = 0.7;        // px
constexpr double kCoarsestBlur = 8;        // px: beyond it too little texture is left
constexpr double kBlurRatio = 0.6;         // from one level to the next
constexpr std::size_t kMinShared = 60;     // points that a view must share with others
constexpr double kMaxPriorSigmas = 6;      // a larger correction is refused
constexpr std::size_t kFewPoints = 4000;   // of a view: enough for all but the last, finest level
constexpr double kBytesPerSighting = 200;  // of an observation, with its equations; counted, rounded up
constexpr double kSightingsShare = 0.5;    // of the memory; the rest is for blurred images

void checkInput(const AlignmentInput& input) {
  require<std::invalid_argument>(
      input.surfels.radii.size() == input.points.cols() && input.surfels.normals.cols() == input.points.cols() &&
          (input.surfels.offsets.size() == 0 || input.surfels.offsets.size() == input.points.cols()),
      "alignment: ", input.points.cols(), " points but ", input.surfels.radii.size(), " surfels");
  require<std::invalid_argument>(input.intensity.size() == 0 || input.intensity.size() == input.points.cols(),
                                 "alignment: ", input.points.cols(), " points but ", input.intensity.size(),
                                 " intensities");
  for (std::size_t v = 0; v < input.views.size(); ++v) {
    require<std::invalid_argument>(input.views[v].camera < input.cameras.size(), "alignment: view ", v,
                                   " is of camera ", input.views[v].camera, ", but there are ", input.cameras.size());
  }
  require<std::invalid_argument>(input.views.empty() || (input.images && input.depth),
                                 "alignment: needs a source of images and of depth images");
}

// A camera whose images are not 8-bit, or -1.
int cameraBeyond8Bit(const AlignmentInput& input) {
  std::vector<bool> seen(input.cameras.size(), false);
  for (std::size_t v = 0; v < input.views.size(); ++v) {
    const std::uint32_t camera = input.views[v].camera;
    if (seen[camera]) continue;
    seen[camera] = true;
    const auto image = input.images(v);
    if (image && image->depth() != CV_8U) return static_cast<int>(camera);
  }
  return -1;
}

// The input with its points moved onto the surface, as all stages look at them.
AlignmentInput onSurface(const AlignmentInput& input) {
  AlignmentInput moved = input;
  for (Eigen::Index i = 0; i < moved.points.cols(); ++i) {
    moved.points.col(i) = input.surfels.onSurface(i, input.points.col(i));
  }
  moved.surfels.offsets.resize(0);
  return moved;
}

// Everything that align() works on.
class Aligner {
 public:
  Aligner(const AlignmentInput& input, const AlignmentParams& params, const Callbacks& callbacks)
      : input_(input),
        params_(params),
        callbacks_(callbacks),
        runs_(makeRuns(input.points, input.surfels)),
        sightings_(input.views.size()) {
    const double room = kSightingsShare * 1e6 * input.memory_limit / kBytesPerSighting;
    const double points = room / static_cast<double>(std::max<std::size_t>(1, input.views.size()));
    max_points_ = static_cast<std::size_t>(std::clamp<double>(points, 100, params.alignment_points));
    state_.views.assign(input.views.size(), Twist::Zero());
    state_.cameras.assign(input.cameras.size(), Twist::Zero());
    state_.time_offsets.assign(input.cameras.size(), 0);
    seen_at_ = state_;
    log_gains_ = Eigen::VectorXd::Zero(static_cast<Eigen::Index>(input.views.size()));
    result_.views.resize(input.views.size());
    result_.cameras.resize(input.cameras.size());
    for (std::size_t v = 0; v < input.views.size(); ++v) {
      result_.views[v].map_from_camera = input.views[v].map_from_camera;
    }
  }

  AlignmentResult run();

 private:
  void look(bool all, std::size_t points);
  std::vector<double> medianDepths() const;
  bool hasOverlap();
  void findClocks();
  void refine();
  void updateGains(const PoseData& data);
  void shrink(const PoseData& data);
  void refuse();
  void report();
  void warnAboutCamera(std::size_t c);
  std::size_t fewPoints() const { return std::min(max_points_, kFewPoints); }
  double startBlur() const;
  std::vector<double> levels() const;
  std::vector<float> residuals(const PoseState& state, double sigma, std::vector<float>& by_view) const;
  double pixelsOf(std::size_t view, const PoseState& from) const;
  void poll(const std::string& stage, std::size_t done, std::size_t total) const;

  const AlignmentInput& input_;
  const AlignmentParams& params_;
  const Callbacks& callbacks_;
  std::vector<PointRun> runs_;
  std::size_t max_points_ = 0;  // of a view
  std::vector<std::vector<Sighting>> sightings_;
  Tracks tracks_;
  PosePriors priors_;
  PoseState state_, seen_at_;
  Eigen::VectorXd log_gains_;
  Eigen::VectorXf ranks_;  // of the intensities; empty: no tie to them
  AlignmentResult result_;
};

void Aligner::poll(const std::string& stage, std::size_t done, std::size_t total) const {
  if (callbacks_.cancelled && callbacks_.cancelled()) throw Cancelled();
  if (!callbacks_.progress) return;
  Progress progress;
  progress.stage = stage;
  progress.done = done;
  progress.total = total;
  callbacks_.progress(progress);
}

// Median shift of a view's points between two corrections, in pixels.
double Aligner::pixelsOf(std::size_t view, const PoseState& from) const {
  const Camera& camera = input_.cameras[input_.views[view].camera];
  const Eigen::Isometry3d a = correctedPose(input_.views[view], from.views[view]).inverse();
  const Eigen::Isometry3d b = correctedPose(input_.views[view], state_.views[view]).inverse();
  std::vector<float> shifts;
  const std::size_t stride = std::max<std::size_t>(1, sightings_[view].size() / 500);
  for (std::size_t i = 0; i < sightings_[view].size(); i += stride) {
    const Eigen::Vector3d point = input_.points.col(sightings_[view][i].point).cast<double>();
    const auto pixel_a = camera.linearize(a * point), pixel_b = camera.linearize(b * point);
    if (pixel_a && pixel_b) shifts.push_back(static_cast<float>((pixel_a->pixel - pixel_b->pixel).norm()));
  }
  return median(std::move(shifts));
}

// Looks again which view sees which point, only in those views that have moved, unless `all`; and makes tracks of at
// most so many points of each view.
void Aligner::look(bool all, std::size_t points) {
  constexpr double kMovedPixels = 1.5;
  parallelFor(input_.num_threads, input_.views.size(), [&](std::size_t v) {
    if (!all && pixelsOf(v, seen_at_) < kMovedPixels) return;
    const Eigen::Isometry3d pose = correctedPose(input_.views[v], state_.views[v]);
    sightings_[v] = findSightings(input_, runs_, v, pose, max_points_);
    seen_at_.views[v] = state_.views[v];
  });
  tracks_ = makeTracks(sightings_, static_cast<std::size_t>(input_.points.cols()), points);
}

// Of each view, m.
std::vector<double> Aligner::medianDepths() const {
  std::vector<double> medians;
  for (std::size_t v = 0; v < input_.views.size(); ++v) {
    const Eigen::Isometry3d camera_from_map = correctedPose(input_.views[v], state_.views[v]).inverse();
    std::vector<float> depths;
    for (const Sighting& s : sightings_[v]) {
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
    for (const Sighting& s : sightings_[v]) {
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

// As many pixels as the priors let a point be off.
double Aligner::startBlur() const {
  if (params_.alignment_blur > 0) return std::max(params_.alignment_blur, kFinestBlur);
  double focal = 0;
  for (const Camera& camera : input_.cameras) focal = std::max(focal, camera.intrinsics().fx);
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

void Aligner::updateGains(const PoseData& data) {
  const Eigen::VectorXd none = Eigen::VectorXd::Zero(log_gains_.size());
  PoseData raw = data;
  raw.log_gains = &none;
  const GreyValues grey = greyValues(raw, state_, input_.num_threads);
  log_gains_ = estimateLogGains(tracks_, grey.values, grey.weights, params_.max_gain, input_.num_threads);
}

// The clocks are always looked at, because they are the commonest fault; they are corrected only if asked for.
void Aligner::findClocks() {
  constexpr double kSuspect = 0.01;  // s
  const double sigma = startBlur();
  const BlurredImages images(input_, sigma);
  const PoseData data{&input_, &tracks_, &images, &log_gains_, sigma, ranks_.size() > 0 ? &ranks_ : nullptr};
  updateGains(data);
  PosePriors free = priors_;
  free.time_sigmas.assign(input_.cameras.size(), params_.time_offset_prior);
  const double common = searchTimeOffset(data, free, state_, input_.num_threads);
  PoseState state = state_;
  for (double& offset : state.time_offsets) offset = common;
  for (std::size_t v = 0; v < state.views.size(); ++v) state.views[v] += common * priors_.velocities[v];
  const PoseRounds rounds = refinePoses(data, free, params_.alignment_rounds, input_.num_threads, state);
  for (std::size_t c = 0; c < input_.cameras.size(); ++c) {
    CameraAlignment& camera = result_.cameras[c];
    if (rounds.time_stddevs[c] > 0.9 * params_.time_offset_prior) continue;  // nothing moves
    camera.time_offset = state.time_offsets[c];
    camera.time_offset_stddev = rounds.time_stddevs[c];
    camera.time_offset_suspect = std::abs(camera.time_offset) > std::max(kSuspect, 4 * camera.time_offset_stddev);
  }
  if (params_.align_time_offset) state_ = state;
}

void Aligner::refine() {
  look(false, fewPoints());
  findClocks();
  const std::vector<double> sigmas = levels();
  for (std::size_t level = 0; level < sigmas.size(); ++level) {
    poll("align poses", level, sigmas.size());
    look(false, level + 1 < sigmas.size() ? fewPoints() : max_points_);
    const BlurredImages images(input_, sigmas[level]);
    const PoseData data{&input_, &tracks_, &images, &log_gains_, sigmas[level], ranks_.size() > 0 ? &ranks_ : nullptr};
    updateGains(data);
    if (level > 0) learnSteps(input_.views, state_, priors_);
    const PoseRounds rounds = refinePoses(data, priors_, params_.alignment_rounds, input_.num_threads, state_);
    if (level + 1 == sigmas.size()) shrink(data);
    if (!callbacks_.log) continue;
    std::ostringstream text;
    text << "Alignment at a blur of " << sigmas[level] << " px: residual " << rounds.residual_first << " to "
         << rounds.residual_last << " grey levels in " << rounds.accepted << " steps";
    if (rounds.explained > 0) text << ", intensity explains " << 100 * rounds.explained << " %";
    callbacks_.log(LogLevel::kInfo, text.str());
  }
  poll("align poses", sigmas.size(), sigmas.size());
}

// Corrections that are no larger than their uncertainty are left out.
void Aligner::shrink(const PoseData& data) {
  const PoseShrinkage shrinkage = shrinkPoses(data, priors_, input_.num_threads, state_);
  for (std::size_t c = 0; c < input_.cameras.size(); ++c) {
    const Shrinkage &common = shrinkage.cameras[c], &views = shrinkage.views[c];
    result_.cameras[c].uncertainty = common.uncertainty;
    result_.cameras[c].views_uncertainty = views.uncertainty;
    if (!callbacks_.log || (common.factor > 0 && views.factor > 0)) continue;
    std::ostringstream text;
    text << std::setprecision(2) << "Alignment of camera_" << c << ": corrections no larger than their uncertainty are"
         << " left out (";
    if (common.factor == 0) text << "of the camera: " << common.pixels << " +- " << common.uncertainty << " px";
    if (common.factor == 0 && views.factor == 0) text << ", ";
    if (views.factor == 0) text << "of its views: " << views.pixels << " +- " << views.uncertainty << " px";
    callbacks_.log(LogLevel::kInfo, text.str() + ")");
  }
}

// Median distance of each view's observations to their points' medians, and of all.
std::vector<float> Aligner::residuals(const PoseState& state, double sigma, std::vector<float>& by_view) const {
  const BlurredImages images(input_, sigma);
  const GreyValues grey =
      greyValues({&input_, &tracks_, &images, &log_gains_, sigma, nullptr}, state, input_.num_threads);
  const std::vector<float> medians = pointMedians(tracks_, grey.values, grey.weights);
  std::vector<float> all;
  by_view.assign(tracks_.numViews(), 0);
  for (std::size_t v = 0; v < tracks_.numViews(); ++v) {
    std::vector<float> own;
    for (std::uint32_t k = tracks_.offsets[v]; k < tracks_.offsets[v + 1]; ++k) {
      const std::uint32_t p = tracks_.sightings[k].point;
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
  PoseState before = state_;
  for (auto& twist : before.views) twist.setZero();
  std::vector<float> first, last;
  result_.residual_before = median(residuals(before, kFinestBlur, first));
  result_.residual_after = median(residuals(state_, kFinestBlur, last));
  for (std::size_t v = 0; v < input_.views.size(); ++v) {
    ViewAlignment& view = result_.views[v];
    const std::uint32_t c = input_.views[v].camera;
    const Twist expected = state_.cameras[c] + state_.time_offsets[c] * priors_.velocities[v];
    const double sigmas = (state_.views[v] - expected).cwiseQuotient(priors_.view_sigmas[v]).cwiseAbs().maxCoeff();
    view.residual_before = first[v];
    view.residual_after = last[v];
    std::ostringstream reason;
    if (sigmas > kMaxPriorSigmas) reason << "its correction would be " << sigmas << " times what the priors expect";
    if (last[v] > 1.05F * first[v] + 0.5F) reason << "it would agree worse than before";
    if (reason.str().empty()) continue;
    state_.views[v] = expected;
    view.refused = true;
    view.reason = reason.str();
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
  PoseState before = state_;
  for (auto& twist : before.views) twist.setZero();
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

AlignmentResult Aligner::run() {
  if (!params_.align_exposure && params_.align_poses == AlignPoses::kNone) return std::move(result_);
  if (const int camera = cameraBeyond8Bit(input_); camera >= 0) {
    result_.warnings.push_back("Nothing was aligned: the images of camera_" + std::to_string(camera) +
                               " are not 8 bits a channel; convert them, or set align_exposure false and align_poses "
                               "none to be without this warning.");
    return std::move(result_);
  }
  if (params_.align_to_intensity) ranks_ = intensityRanks(input_.intensity);
  look(true, max_points_);
  if (!hasOverlap()) return std::move(result_);
  priors_ = makePriors(input_, params_, medianDepths());
  if (params_.align_poses != AlignPoses::kNone) {
    refine();
    refuse();
    result_.poses_aligned = true;
  }
  look(false, fewPoints());
  const double sigma = result_.poses_aligned ? 1.2 : startBlur();
  const auto exposures = estimateExposures(input_, tracks_, state_, sigma, params_);
  const std::vector<float> weights = sharpnessWeights(input_, tracks_, state_, exposures);
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

}  // namespace

void AlignmentParams::check() const {
  requireInRange("alignment_points", alignment_points, 100, 1000000);
  requireInRange("alignment_rounds", alignment_rounds, 1, 100);
  requireInRange("alignment_blur", alignment_blur, 0.0, 50.0);
  requireInRange("pose_rotation_prior", pose_rotation_prior, 1e-4, 10.0);
  requireInRange("pose_translation_prior", pose_translation_prior, 0.0, 10.0);
  requireInRange("extrinsic_rotation_prior", extrinsic_rotation_prior, 1e-4, 10.0);
  requireInRange("extrinsic_translation_prior", extrinsic_translation_prior, 0.0, 10.0);
  requireInRange("time_offset_prior", time_offset_prior, 1e-4, 10.0);
  requireInRange("max_gain", max_gain, 1.0, 20.0);
}

AlignmentResult align(const AlignmentInput& input, const AlignmentParams& params, const Callbacks& callbacks) {
  const auto start = std::chrono::steady_clock::now();
  params.check();
  checkInput(input);
  const AlignmentInput moved = onSurface(input);
  AlignmentResult result = Aligner(moved, params, callbacks).run();
  result.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  return result;
}

}  // namespace cloud_colorizer
