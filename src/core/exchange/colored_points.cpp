// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause
#include "exchange/colored_points.hpp"

#include <algorithm>
#include <cstring>

#include "cloud_colorizer/map/colorize.hpp"

namespace cloud_colorizer {
namespace {

template <class F>
void forEachColoredPoint(const Recording& recording, const Params& params, bool relative, const F& f) {
  forEachColoredTile(recording, params, relative, [&](const Cloud& cloud) {
    const auto rgb = findField(cloud.fields, "rgb"), count = findField(cloud.fields, "view_count");
    const std::size_t size = recordSize(cloud.fields);
    for (Eigen::Index i = 0; i < cloud.positions.cols(); ++i) {
      const std::uint8_t* record = cloud.records.data() + static_cast<std::size_t>(i) * size;
      if (numberAt(record + count->offset, count->field.type) == 0) continue;
      std::uint32_t color = 0;
      std::memcpy(&color, record + rgb->offset, sizeof color);
      f(cloud.positions.col(i), color);
    }
  });
}

}  // namespace

void forSomeColoredPoints(const Recording& recording, const Params& params, std::size_t most, bool relative,
                          const std::function<void(const Eigen::Vector3d&, std::uint32_t)>& f) {
  std::size_t count = 0, index = 0;
  forEachColoredPoint(recording, params, relative, [&](const Eigen::Vector3d&, std::uint32_t) { ++count; });
  const std::size_t step = std::max<std::size_t>(1, (count + most - 1) / std::max<std::size_t>(1, most));
  forEachColoredPoint(recording, params, relative, [&](const Eigen::Vector3d& at, std::uint32_t color) {
    if (index++ % step == 0) f(at, color);
  });
}

}  // namespace cloud_colorizer
