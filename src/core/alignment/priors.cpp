// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause
#include "alignment/priors.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>

#include "base/robust.hpp"

namespace cloud_colorizer::alignment {
namespace {

constexpr double kStiff = 1e-4;  // of a prior: a correction that is not asked for

// A translation moves a point at this depth as many pixels as the rotation does.
Twist sigmas(double rotation_deg, double depth) {
  const double rotation = rotation_deg * M_PI / 180;
  Twist twist;
  twist.head<3>().setConstant(rotation);
  twist.tail<3>().setConstant(rotation * depth);
  return twist;
}

// Views of each camera by ascending stamp.
std::vector<std::vector<std::size_t>> byCameraAndTime(const std::vector<View>& views) {
  std::vector<std::vector<std::size_t>> order;
  for (std::size_t v = 0; v < views.size(); ++v) {
    if (views[v].camera >= order.size()) order.resize(views[v].camera + 1);
    order[views[v].camera].push_back(v);
  }
  for (auto& camera : order) {
    std::stable_sort(camera.begin(), camera.end(), [&](auto a, auto b) { return views[a].stamp < views[b].stamp; });
  }
  return order;
}

}  // namespace

std::vector<Twist> viewVelocities(const std::vector<View>& views) {
  std::vector<Twist> velocities(views.size(), Twist::Zero());
  for (const auto& camera : byCameraAndTime(views)) {
    for (std::size_t i = 0; i < camera.size(); ++i) {
      const View& now = views[camera[i]];
      const View& before = views[camera[i > 0 ? i - 1 : i]];
      const View& after = views[camera[std::min(i + 1, camera.size() - 1)]];
      const bool use_before = now.stamp - before.stamp <= kMaxStampGap,
                 use_after = after.stamp - now.stamp <= kMaxStampGap;
      const View& from = use_before ? before : now;
      const View& to = use_after ? after : now;
      const double elapsed = to.stamp - from.stamp;
      if (!(elapsed > 1e-6)) continue;
      velocities[camera[i]] = twistOf(to.map_from_camera.inverse() * from.map_from_camera) / elapsed;
    }
  }
  return velocities;
}

PosePriors makePriors(const AlignmentInput& input, const AlignmentParams& params, const std::vector<double>& depths) {
  PosePriors priors;
  std::vector<double> camera_depths(input.cameras.size(), 0), counts(input.cameras.size(), 0);
  for (std::size_t v = 0; v < input.views.size(); ++v) {
    if (!(depths[v] > 0)) continue;
    camera_depths[input.views[v].camera] += depths[v];
    ++counts[input.views[v].camera];
  }
  const double total = std::accumulate(camera_depths.begin(), camera_depths.end(), 0.0);
  const double mean = std::max(1e-9, total / std::max(1.0, std::accumulate(counts.begin(), counts.end(), 0.0)));
  for (std::size_t v = 0; v < input.views.size(); ++v) {
    const double depth = depths[v] > 0 ? depths[v] : mean;
    priors.view_sigmas.push_back(sigmas(params.pose_rotation_prior, depth));
    if (params.align_poses != AlignPoses::kViews) priors.view_sigmas.back() *= kStiff;
  }
  for (std::size_t c = 0; c < input.cameras.size(); ++c) {
    const double depth = counts[c] > 0 ? camera_depths[c] / counts[c] : mean;
    priors.camera_sigmas.push_back(sigmas(params.extrinsic_rotation_prior, depth));
    priors.time_sigmas.push_back(params.time_offset_prior * (params.align_time_offset ? 1 : kStiff));
  }
  priors.velocities = viewVelocities(input.views);
  priors.previous.resize(input.views.size());
  std::iota(priors.previous.begin(), priors.previous.end(), std::size_t{0});
  for (const auto& camera : byCameraAndTime(input.views)) {
    for (std::size_t i = 1; i < camera.size(); ++i) {
      const double gap = input.views[camera[i]].stamp - input.views[camera[i - 1]].stamp;
      if (gap <= kMaxStampGap) priors.previous[camera[i]] = camera[i - 1];
    }
  }
  return priors;
}

void learnSteps(const std::vector<View>& views, const PoseState& state, PosePriors& priors) {
  constexpr std::size_t kMinSteps = 10;  // that tell a spread
  constexpr double kLeast = 0.05;        // of the mean prior of the camera's views
  std::vector<Twist> step_sigmas(state.cameras.size(), Twist::Constant(INFINITY));
  bool any = false;
  for (std::size_t c = 0; c < state.cameras.size(); ++c) {
    std::array<std::vector<float>, 6> sizes;
    Twist prior = Twist::Zero();
    for (std::size_t v = 0; v < views.size(); ++v) {
      if (views[v].camera != c || priors.previous[v] == v) continue;
      const Twist step = state.views[v] - state.views[priors.previous[v]];
      for (Eigen::Index i = 0; i < 6; ++i)
        sizes[static_cast<std::size_t>(i)].push_back(std::abs(static_cast<float>(step[i])));
      prior += priors.view_sigmas[v];
    }
    const std::size_t count = sizes[0].size();
    if (count < kMinSteps) continue;
    any = true;
    for (Eigen::Index i = 0; i < 6; ++i) {
      const double measured = kMadToSigma * static_cast<double>(median(sizes[static_cast<std::size_t>(i)]));
      step_sigmas[c][i] = std::max(kLeast * prior[i] / static_cast<double>(count), measured);
    }
  }
  if (any) priors.step_sigmas = std::move(step_sigmas);
}

}  // namespace cloud_colorizer::alignment
