// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause
#include "evaluation/clouds.hpp"

#include "cloud/cloud_colors.hpp"
#include "cloud_colorizer/base/check.hpp"
#include "cloud_colorizer/cloud/cloud_io.hpp"

namespace cloud_colorizer {

using Eigen::Index;

ColoredCloud coloredCloud(const Cloud& cloud, const std::string& source) {
  const CloudColors fields(cloud.fields, source);
  const auto views = findField(cloud.fields, "view_count");
  const std::size_t size = recordSize(cloud.fields);
  ColoredCloud colored{cloud.positions, fields.read(cloud), {}, ""};
  colored.count.assign(static_cast<std::size_t>(cloud.positions.cols()), 1);
  if (!fields.isBytes() && colored.colors.size() > 0) {
    const float largest = colored.colors.maxCoeff();
    colored.colors *= fields.scale(largest);
    colored.note = fields.describe(largest);
  }
  for (std::size_t p = 0; views && p < colored.count.size(); ++p) {
    const std::uint8_t* number = cloud.records.data() + p * size + views->offset;
    colored.count[p] = static_cast<std::uint16_t>(numberAt(number, views->field.type));
  }
  return colored;
}

ColoredCloud readColoredCloud(const std::string& path) {
  CloudReader reader(path);
  ColoredCloud all = coloredCloud(reader.read(reader.numPoints()), path);
  Index kept = 0;
  for (Index p = 0; p < all.positions.cols(); ++p) {
    if (all.count[static_cast<std::size_t>(p)] == 0 || !all.positions.col(p).allFinite()) continue;
    all.positions.col(kept) = all.positions.col(p).eval();
    all.colors.col(kept) = all.colors.col(p).eval();
    all.count[static_cast<std::size_t>(kept++)] = all.count[static_cast<std::size_t>(p)];
  }
  require(kept > 0, path, ": the cloud has no coloured point");
  all.positions.conservativeResize(3, kept);
  all.colors.conservativeResize(3, kept);
  all.count.resize(static_cast<std::size_t>(kept));
  return all;
}

}  // namespace cloud_colorizer
