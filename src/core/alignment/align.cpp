// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause
#include "cloud_colorizer/alignment/align.hpp"

#include <algorithm>

#include "alignment/aligner.hpp"
#include "base/robust.hpp"
#include "base/stop_watch.hpp"
#include "cloud_colorizer/base/check.hpp"

namespace cloud_colorizer {
namespace {

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

// The input with its points moved onto the surface, as all stages look at them.
AlignmentInput onSurface(const AlignmentInput& input) {
  AlignmentInput moved = input;
  for (Eigen::Index i = 0; i < moved.points.cols(); ++i) {
    moved.points.col(i) = input.surfels.onSurface(i, input.points.col(i));
  }
  moved.surfels.offsets.resize(0);
  return moved;
}

// m: twice the scatter of the points about their surface.
double thickness(const Surfels& surfels) {
  std::vector<float> distances(surfels.offsets.data(), surfels.offsets.data() + surfels.offsets.size());
  for (float& distance : distances) distance = std::abs(distance);
  return 2 * kMadToSigma * static_cast<double>(median(std::move(distances)));
}

}  // namespace

void AlignmentParams::check() const {
  requireInRange("alignment_points", alignment_points, 100, 1000000);
  requireInRange("pose_rotation_prior", pose_rotation_prior, 1e-4, 10.0);
  requireInRange("extrinsic_rotation_prior", extrinsic_rotation_prior, 1e-4, 10.0);
  requireInRange("time_offset_prior", time_offset_prior, 1e-4, 10.0);
}

std::size_t AlignmentParams::pointsPerView(std::size_t num_views) const {
  // Of all views together: 450 MB with their equations, whatever memory_limit is, for the result must not depend on it.
  constexpr double kMaxSights = 2.25e6;
  constexpr double kMinPoints = 100;  // of a view, however many there are
  const double points = kMaxSights / static_cast<double>(std::max<std::size_t>(1, num_views));
  return static_cast<std::size_t>(std::clamp<double>(points, kMinPoints, alignment_points));
}

AlignmentResult align(const AlignmentInput& input, const AlignmentParams& params, const Callbacks& callbacks) {
  StopWatch watch;
  params.check();
  checkInput(input);
  const AlignmentInput moved = onSurface(input);
  AlignmentResult result = alignment::Aligner(moved, thickness(input.surfels), params, callbacks).run();
  result.seconds = watch.lap();
  return result;
}

}  // namespace cloud_colorizer
