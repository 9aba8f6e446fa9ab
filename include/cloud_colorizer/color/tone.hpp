// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause

/// Tone: from the brightness that all views agree on to one that 8 bits hold. A camera drives out of the shade and
/// lowers its exposure; gains that undo it make the shaded street black and the sunny one white. So the map follows,
/// smoothly over metres, what the cameras saw of each place, as far as that is needed.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <map>

#include "cloud_colorizer/base/types.hpp"

namespace cloud_colorizer {

struct ToneParams {
  double exposure_range = 1.1;  ///< factor by which the brightness of a place may differ from what its cameras saw;
                                ///< beyond it the map follows them

  void check() const;
};

/// Samples of the logarithm of the gain that made the views of a point agree with the others.
struct ToneSum {
  double log_gain = 0, count = 0;
};
using ToneCell = std::array<std::int32_t, 3>;  ///< the cube [index, index + 1) * cell size
using ToneCells = std::map<ToneCell, ToneSum>;

class ToneField {
 public:
  ToneField() = default;  ///< changes nothing
  /// Blurs the samples over about two cells. `cell`: m, side of the cells.
  ToneField(const ToneCells& samples, double cell, const ToneParams& params);

  /// Multiplies the values (m x n) of points by the factors of their places.
  void apply(PointsRef points, Values& values) const;

  static ToneCell cellOf(const Eigen::Vector3f& place, double cell);

 private:
  double cell_ = 1;
  std::map<ToneCell, float> log_factors_;  ///< at the centres of cells
};

}  // namespace cloud_colorizer
