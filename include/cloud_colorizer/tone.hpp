// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause

/// Tone: from the brightness that all views agree on to one that 8 bits hold. A camera drives out of the shade and
/// lowers its exposure; gains that undo it make the shaded street black and the sunny one white. So the map follows,
/// smoothly over metres, what the cameras saw of each place, as far as that is needed.
#pragma once

#include <Eigen/Geometry>
#include <vector>

#include "cloud_colorizer/types.hpp"

namespace cloud_colorizer {

struct ToneParams {
  double exposure_range = 1.1;  ///< factor by which the brightness of a place may differ from what its cameras saw;
                                ///< beyond it the map follows them

  void check() const;
};

/// What a view tells: where it looks, and the factor that made it agree with the others.
struct ViewTone {
  Eigen::Vector3f place = Eigen::Vector3f::Zero();  ///< m, in the midst of what it sees
  float gain = 1;
};

class ToneField {
 public:
  /// `reach` [m]: views so far from a place still count there by a quarter.
  ToneField(std::vector<ViewTone> views, double reach, const ToneParams& params);

  /// Multiplies the values of points in a box: exact at its corners, trilinear between them, so that boxes that share a
  /// side agree on it. `values`: m x n, of the points' columns.
  void apply(const Eigen::AlignedBox3f& box, PointsRef points, Values& values) const;

  /// The factor at one place.
  float factorAt(const Eigen::Vector3f& place) const;

 private:
  std::vector<ViewTone> views_;
  float reach_, limit_;  ///< m; log
  bool changes_ = false;
};

}  // namespace cloud_colorizer
