// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause
#include "alignment/significance.hpp"

#include <algorithm>
#include <cmath>

#include "alignment/pose_system.hpp"
#include "base/robust.hpp"

namespace cloud_colorizer::alignment {
namespace {

using Matrix6 = Eigen::Matrix<double, 6, 6>;
using Matrices6 = std::vector<Matrix6, Eigen::aligned_allocator<Matrix6>>;

constexpr double kBlockPixels = 40;  // side of a block, seen from the median distance
// px: what no scatter shows, because the whole map has it (interpolation, thickness of the surface). On exact data the
// corrections were 0.02 to 0.12 px where the scatter says 0.02.
constexpr double kSystematic = 0.1;

// Side of a block of the map, m.
double blockSide(const PoseData& data, const PoseState& state) {
  std::vector<float> sizes;
  const Tracks& tracks = *data.tracks;
  for (std::size_t v = 0; v < tracks.numViews(); ++v) {
    const Eigen::Isometry3d camera_from_map = correctedPose(data.input->views[v], state.views[v]).inverse();
    const double focal = data.input->cameras[data.input->views[v].camera].intrinsics().fx;
    for (std::uint32_t k = tracks.offsets[v]; k < tracks.offsets[v + 1]; k += 97) {
      const Eigen::Vector3d point = data.input->points.col(tracks.sights[k].point).cast<double>();
      sizes.push_back(static_cast<float>((camera_from_map * point).z() / focal));
    }
  }
  return kBlockPixels * std::max(1e-9F, median(std::move(sizes)));
}

// Of each group on all unknowns: one column a group.
Eigen::MatrixXd groupPulls(const PoseData& data, const PoseEquations& equations, const PointGroups& groups,
                           Eigen::Index size) {
  const Tracks& tracks = *data.tracks;
  Eigen::MatrixXd pulls = Eigen::MatrixXd::Zero(size, kPointGroups);
  const Eigen::VectorXd means = pointMeans(tracks, equations.equations);
  data.workers->forEach(tracks.numViews(), [&](std::size_t v) {
    const auto row = static_cast<Eigen::Index>(6 * v);
    for (std::uint32_t k = tracks.offsets[v]; k < tracks.offsets[v + 1]; ++k) {
      const double w = equations.equations.weights[k];
      if (!(w > 0)) continue;
      const std::uint32_t p = tracks.sights[k].point;
      pulls.col(groups[p]).segment<6>(row) +=
          w * (equations.equations.values[k] - means[p]) * equations.equations.jacobians[k].cast<double>();
    }
  });
  const Eigen::MatrixXd& ties = equations.intensity.group_gradients;
  if (ties.size() > 0) pulls.topRows(ties.rows()) += ties;
  return pulls;
}

// Mean of J'J, J = d pixel / d correction, over some of a view's points: x'Mx is the mean square shift, px^2.
Matrix6 shiftMatrix(const PoseData& data, const PoseState& state, std::size_t v) {
  constexpr std::size_t kPoints = 300;
  Matrix6 sum = Matrix6::Zero();
  double count = 0;
  const std::size_t stride = 1 + (data.tracks->offsets[v + 1] - data.tracks->offsets[v]) / kPoints;
  const auto add = [&](std::size_t, const Eigen::Vector3d& local, const auto& projected) {
    Eigen::Matrix<double, 3, 6> by_twist;
    by_twist << 0, local.z(), -local.y(), 1, 0, 0,  //
        -local.z(), 0, local.x(), 0, 1, 0,          //
        local.y(), -local.x(), 0, 0, 0, 1;
    const Eigen::Matrix<double, 2, 6> jacobian = projected.jacobian * by_twist;
    sum += jacobian.transpose() * jacobian;
    ++count;
  };
  forEachSight(*data.input, *data.tracks, state, v, -INFINITY, add, stride);
  return count > 0 ? Matrix6(sum / count) : sum;
}

double squaredShift(const Matrix6& shift, const Twist& twist) {
  return twist.dot(shift * twist);
}

// Sum over the groups of the squared shift that one group's leaving would make.
template <class Column>
double squaredUncertainty(const Matrix6& shift, const Column& of_group) {
  Eigen::Matrix<double, 6, kPointGroups> steps;
  for (Eigen::Index g = 0; g < kPointGroups; ++g) steps.col(g) = of_group(g);
  const Twist mean = steps.rowwise().mean();
  double sum = 0;
  for (Eigen::Index g = 0; g < kPointGroups; ++g) sum += squaredShift(shift, steps.col(g) - mean);
  return sum * kPointGroups / (kPointGroups - 1.0);
}

Shrinkage makeShrinkage(double squares, double squared_uncertainty, double count) {
  Shrinkage shrinkage;
  shrinkage.pixels = std::sqrt(squares / std::max(1.0, count));
  shrinkage.uncertainty = std::hypot(std::sqrt(squared_uncertainty / std::max(1.0, count)), kSystematic);
  shrinkage.factor = shrinkFactor(shrinkage.pixels, shrinkage.uncertainty);
  return shrinkage;
}

// Of what no uncertainty can be told nothing is kept.
PoseShrinkage dropAll(PoseState& state) {
  const std::vector<Shrinkage> none(state.cameras.size(), Shrinkage{0, INFINITY, 0});
  for (auto* twists : {&state.views, &state.cameras}) std::fill(twists->begin(), twists->end(), Twist::Zero());
  return {none, none};
}

}  // namespace

double shrinkFactor(double size, double uncertainty) {
  constexpr double kKappa = 2;
  if (!(uncertainty > 0)) return 1;
  if (!(size > 0)) return 0;
  return std::max(0.0, 1 - std::pow(kKappa * std::pow(uncertainty / size, 2), 2));
}

double shrinkFactor(double group_size, double own_size, double uncertainty) {
  return std::max(shrinkFactor(group_size, uncertainty), shrinkFactor(own_size, 1.5 * uncertainty));
}

PointGroups groupPoints(const AlignmentInput& input, double block) {
  PointGroups groups(static_cast<std::size_t>(input.points.cols()));
  for (std::size_t p = 0; p < groups.size(); ++p) {
    const Eigen::Vector3d cell = input.points.col(static_cast<Eigen::Index>(p)).cast<double>() / block;
    std::uint64_t hash = 0;
    for (int axis = 0; axis < 3; ++axis) {
      hash =
          (hash ^ static_cast<std::uint64_t>(static_cast<std::int64_t>(std::floor(cell[axis])))) * 0x9E3779B97F4A7C15U;
      hash ^= hash >> 29;
    }
    groups[p] = static_cast<std::uint8_t>(hash % kPointGroups);
  }
  return groups;
}

PoseShrinkage shrinkPoses(const PoseData& data, const PosePriors& priors, PoseState& state) {
  const std::vector<View>& views = data.input->views;
  const PriorTerms terms(views, priors);
  const PointGroups groups = groupPoints(*data.input, blockSide(data, state));
  const PoseEquations equations = poseEquations(data, state, {}, groups);
  const PoseSystem system = assemblePoseSystem(data, equations, terms, state);
  const auto solved = solveLower(system.lower, groupPulls(data, equations, groups, terms.size()));
  if (!solved) return dropAll(state);
  const Eigen::MatrixXd& steps = *solved;
  const std::size_t num_cameras = state.cameras.size();
  Matrices6 shifts(num_cameras, Matrix6::Zero());
  std::vector<double> counts(num_cameras, 0), squares(num_cameras, 0), uncertain(num_cameras, 0);
  std::vector<Twist> own(views.size());  // a view's correction without its camera's
  std::vector<double> own_pixels(views.size(), 0);
  for (std::size_t v = 0; v < views.size(); ++v) {
    const std::uint32_t c = views[v].camera;
    own[v] = state.views[v] - state.cameras[c] - state.time_offsets[c] * priors.velocities[v];
    if (data.tracks->offsets[v] == data.tracks->offsets[v + 1]) continue;
    const Matrix6 shift = shiftMatrix(data, state, v);
    const auto row = static_cast<Eigen::Index>(6 * v), base = terms.cameraBase(c);
    own_pixels[v] = std::sqrt(squaredShift(shift, own[v]));
    squares[c] += std::pow(own_pixels[v], 2);
    uncertain[c] += squaredUncertainty(shift, [&](Eigen::Index g) -> Twist {
      return steps.col(g).segment<6>(row) - steps.col(g).segment<6>(base) - steps(base + 6, g) * priors.velocities[v];
    });
    shifts[c] += shift;
    ++counts[c];
  }
  PoseShrinkage result;
  for (std::size_t c = 0; c < num_cameras; ++c) {
    const auto base = terms.cameraBase(c);
    const double common =
        squaredUncertainty(shifts[c], [&](Eigen::Index g) -> Twist { return steps.col(g).segment<6>(base); });
    result.cameras.push_back(makeShrinkage(squaredShift(shifts[c], state.cameras[c]), common, counts[c]));
    result.views.push_back(makeShrinkage(squares[c], uncertain[c], counts[c]));
    state.cameras[c] *= result.cameras[c].factor;
  }
  for (std::size_t v = 0; v < views.size(); ++v) {
    const std::uint32_t c = views[v].camera;
    const double kept = shrinkFactor(result.views[c].pixels, own_pixels[v], result.views[c].uncertainty);
    state.views[v] = state.cameras[c] + state.time_offsets[c] * priors.velocities[v] + kept * own[v];
  }
  return result;
}

}  // namespace cloud_colorizer::alignment
