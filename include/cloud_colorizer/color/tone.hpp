// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause

/// Tone: from radiance, the values that all views agree on after their gains, to what 8 bits hold. A camera drives out
/// of the shade and lowers its exposure; gains that undo it make the shaded street black and the sunny one white. So
/// the map is shown as bright as its cameras saw each place, but changes smoothly from place to place, and highlights
/// are compressed instead of cut off.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <map>
#include <vector>

#include "cloud_colorizer/base/types.hpp"
#include "cloud_colorizer/visibility/observe.hpp"

namespace cloud_colorizer {

/// display: as bright as the images; radiance: in one exposure for the whole map, and unclamped in fields of their own.
enum class Tone { kDisplay, kRadiance };

/// Of the points in a cell.
struct ToneSum {
  std::map<std::uint32_t, double> views;  ///< number of points by the view that sees them, shared among several
  double peak = 0;                        ///< largest channel of the radiance, but for a thousandth of the points
};
using ToneCell = std::array<std::int32_t, 3>;  ///< the cube [index, index + 1) * cell size
using ToneCells = std::map<ToneCell, ToneSum>;

/// Of the points in `columns`. `cell`: m, side of the cells.
ToneCells countViews(PointsRef points, const std::vector<Eigen::Index>& columns, const Observations& seen, double cell);
/// The peaks of these cells. `radiance`: m x n.
void addPeaks(PointsRef points, const Values& radiance, double cell, ToneCells& cells);
/// A cell may have got points in several tiles.
void addCells(const ToneCells& more, ToneCells& cells);

class ToneField {
 public:
  ToneField() = default;  ///< changes nothing
  /// `log_gains`: of each view, logarithm of what made its values radiances.
  ToneField(const ToneCells& cells, const std::vector<float>& log_gains, double cell, Tone tone);

  /// What brings the radiances (m x n) of points to 0 to 255, one factor a point.
  Eigen::RowVectorXf factors(PointsRef points, const Values& radiance) const;

 private:
  double cell_ = 1;
  std::map<ToneCell, float> log_factors_;  ///< at the centres of cells
  double peak_ = 0;                        ///< nearly the largest value with these factors
};

}  // namespace cloud_colorizer
