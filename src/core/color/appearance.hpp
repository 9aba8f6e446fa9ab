// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause

/// Appearances that depend on the view: v_p^i = c_p + a_p B(p, i) s + noise. B are the functions of AppearanceBasis, s
/// their strengths in a neighbourhood, a_p how much of them the point itself shows.
#pragma once

#include <vector>

#include "color/light.hpp"

namespace cloud_colorizer {

/// What was taken out of the observations, a column a point; zeros where nothing was proved.
struct Sheen {
  Eigen::Matrix3Xf mean;   ///< over the views of the point, weighted
  Eigen::Matrix3Xf least;  ///< of the view that shows least of it
  Eigen::Matrix3Xf most;   ///< of the view that shows most of it
};

/// Takes a_p B s out of the values of `observations`.
///
/// c_p is a fixed effect: values and functions are taken less their means over the views of the point, so that texture
/// cannot pass for sheen. In cells of side `cell` [m] and for each of six directions of the normal,
///   s = (sum w B' B'^T + mu sum w I)^-1 sum w B' v'^T
/// over a part of the points of the cell and, with less weight, of those beside it; in a second round views that differ
/// from it count less. A quarter of a cell at a time is left out and predicted by the rest: unless that explains more
/// than two hundredths, and more than twice the scatter between the quarters, s is 0. Between cells s is linear. a_p is
/// 1 unless the point's own views say otherwise, from 0 to 2.
Sheen takeOutSheen(const Sights& sights, Appearance appearance, float cell, Observations& observations);

}  // namespace cloud_colorizer
