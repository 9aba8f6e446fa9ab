// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause
#include "cloud_colorizer/tone.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "cloud_colorizer/check.hpp"

namespace cloud_colorizer {

void ToneParams::check() const {
  requireInRange("exposure_range", exposure_range, 1.0, 1e6);
}

ToneField::ToneField(std::vector<ViewTone> views, double reach, const ToneParams& params)
    : views_(std::move(views)), reach_(static_cast<float>(reach)) {
  params.check();
  requireInRange("the reach of tones", reach, 1e-9, 1e9);
  limit_ = static_cast<float>(std::log(params.exposure_range));
  for (ViewTone& view : views_) {
    require<std::invalid_argument>(view.gain > 0 && std::isfinite(view.gain), "the gain of a view is ", view.gain);
    view.gain = std::log(view.gain);
    changes_ = changes_ || std::abs(view.gain) > limit_;
  }
}

float ToneField::factorAt(const Eigen::Vector3f& place) const {
  double sum = 0, weights = 0;
  for (const ViewTone& view : views_) {
    const double squared = (view.place - place).squaredNorm() / (reach_ * reach_);
    const double weight = 1 / ((1 + squared) * (1 + squared));
    sum += weight * view.gain;
    weights += weight;
  }
  const double gain = weights > 0 ? sum / weights : 0;
  const double excess = std::max(0.0, std::abs(gain) - limit_);
  return static_cast<float>(std::exp(gain > 0 ? -excess : excess));
}

void ToneField::apply(const Eigen::AlignedBox3f& box, PointsRef points, Values& values) const {
  if (!changes_) return;
  std::array<float, 8> corners{};
  for (int corner = 0; corner < 8; ++corner) {
    corners[static_cast<std::size_t>(corner)] =
        factorAt(box.corner(static_cast<Eigen::AlignedBox3f::CornerType>(corner)));
  }
  const Eigen::Array3f scale = 1 / box.sizes().array().max(1e-20F);
  for (Eigen::Index i = 0; i < points.cols(); ++i) {
    const Eigen::Array3f at = ((points.col(i) - box.min()).array() * scale).max(0.F).min(1.F);
    float factor = 0;
    for (std::size_t corner = 0; corner < 8; ++corner) {
      float weight = 1;
      for (int axis = 0; axis < 3; ++axis) weight *= (corner >> axis & 1U) != 0 ? at[axis] : 1 - at[axis];
      factor += weight * corners[corner];
    }
    values.col(i) *= factor;
  }
}

}  // namespace cloud_colorizer
