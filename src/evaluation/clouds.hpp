// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause

/// Coloured clouds as numbers.
#pragma once

#include <string>

#include "cloud_colorizer/base/types.hpp"
#include "cloud_colorizer/cloud/cloud.hpp"

namespace cloud_colorizer {

struct ColoredCloud {
  Eigen::Matrix3Xd positions;        ///< 3 x n, m
  Values colors;                     ///< 3 x n
  std::vector<std::uint16_t> count;  ///< n, views of a point; 1 where the cloud does not tell
  std::string note;                  ///< how the colours were brought to 0 to 255, if they were not
};

/// The colours as CloudColors finds them; view_count where there is one. Throws std::runtime_error, naming `source`,
/// when there are no colours.
ColoredCloud coloredCloud(const Cloud& cloud, const std::string& source);

/// Reads a .ply, .pcd or .las. Points without a finite position or with view_count 0 are left out.
ColoredCloud readColoredCloud(const std::string& path);

}  // namespace cloud_colorizer
