// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause

/// Points with their surfels, and picking and joining them by column.
#pragma once

#include <vector>

#include "base/columns.hpp"
#include "cloud_colorizer/base/types.hpp"
#include "cloud_colorizer/surface/surfels.hpp"

namespace cloud_colorizer {

struct Surface {
  Points points;
  Surfels surfels;

  Eigen::Index size() const { return points.cols(); }
};

inline Surface gatherSurface(const Surface& from, const std::vector<Eigen::Index>& columns) {
  return {gatherColumns(from.points, columns),
          {gatherColumns(from.surfels.normals, columns), gatherColumns(from.surfels.radii, columns),
           gatherColumns(from.surfels.offsets, columns), gatherColumns(from.surfels.thicknesses, columns)}};
}

inline Surface concatenate(const std::vector<Surface>& parts) {
  Eigen::Index total = 0;
  for (const Surface& part : parts) total += part.size();
  Surface all{Points(3, total),
              {Eigen::Matrix3Xf(3, total), Eigen::VectorXf(total), Eigen::VectorXf(total), Eigen::VectorXf(total)}};
  Eigen::Index next = 0;
  for (const Surface& part : parts) {
    all.points.middleCols(next, part.size()) = part.points;
    all.surfels.normals.middleCols(next, part.size()) = part.surfels.normals;
    all.surfels.radii.segment(next, part.size()) = part.surfels.radii;
    all.surfels.offsets.segment(next, part.size()) = part.surfels.offsets;
    all.surfels.thicknesses.segment(next, part.size()) = part.surfels.thicknesses;
    next += part.size();
  }
  return all;
}

}  // namespace cloud_colorizer
