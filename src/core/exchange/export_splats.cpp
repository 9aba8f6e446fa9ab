// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause

/// export_model.hpp: Gaussian splats, in the units of Kerbl et al., SIGGRAPH 2023.

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <vector>

#include "cloud_colorizer/cloud/cloud_io.hpp"
#include "cloud_colorizer/exchange/export_model.hpp"
#include "cloud_colorizer/surface/surfels.hpp"
#include "exchange/colored_points.hpp"

namespace cloud_colorizer {
namespace {

constexpr float kOpacity = 0.95F;
constexpr float kWidth = 0.6F;            // standard deviation of a splat, of the radius that closes the surface
constexpr float kFlatness = 0.1F;         // of the width, along the normal
constexpr float kHarmonic0 = 0.2820948F;  // the harmonic of degree 0: 1 / (2 sqrt(pi))

/// What follows the position of a splat in the file: its normal, harmonics of degree 0, opacity (logit), logarithms of
/// its standard deviations [m], rotation (w x y z) whose z axis is the normal.
using Splat = std::array<float, 14>;

std::vector<Field> splatFields() {
  std::vector<Field> fields;
  for (const char* name : {"nx", "ny", "nz", "f_dc_0", "f_dc_1", "f_dc_2", "opacity", "scale_0", "scale_1", "scale_2",
                           "rot_0", "rot_1", "rot_2", "rot_3"}) {
    fields.push_back({name, FieldType::kFloat32, 1});
  }
  return fields;
}

Splat splatOf(const Eigen::Vector3f& normal, float radius, std::uint32_t color) {
  const bool is_flat = !normal.isZero();
  const float width = std::log(std::max(1e-9F, kWidth * std::abs(radius)));
  const float depth = is_flat ? width + std::log(kFlatness) : width;
  const auto harmonic = [color](unsigned shift) {
    return (static_cast<float>(color >> shift & 0xFFU) / 255 - 0.5F) / kHarmonic0;
  };
  const Eigen::Vector3f up = is_flat ? normal : Eigen::Vector3f::UnitZ();
  const Eigen::Quaternionf turn = Eigen::Quaternionf::FromTwoVectors(Eigen::Vector3f::UnitZ(), up);
  return {
      normal.x(), normal.y(), normal.z(), harmonic(16), harmonic(8), harmonic(0), std::log(kOpacity / (1 - kOpacity)),
      width,      width,      depth,      turn.w(),     turn.x(),    turn.y(),    turn.z()};
}

}  // namespace

void exportSplats(const Recording& recording, const Params& params, const std::string& path, std::size_t max_splats) {
  std::vector<Eigen::Vector3f> places;
  std::vector<std::uint32_t> colors;
  forSomeColoredPoints(recording, params, max_splats, true, [&](const Eigen::Vector3d& at, std::uint32_t color) {
    places.emplace_back(at.cast<float>());
    colors.push_back(color);
  });
  const auto count = static_cast<Eigen::Index>(places.size());
  const Eigen::Map<const Points> points(count > 0 ? places[0].data() : nullptr, 3, count);
  const Surfels surfels = count > 0 ? estimateSurfels(points, {}) : Surfels();
  Cloud cloud;
  cloud.fields = splatFields();
  cloud.positions = points.cast<double>();
  cloud.records.resize(places.size() * sizeof(Splat));
  for (std::size_t i = 0; i < places.size(); ++i) {
    const auto column = static_cast<Eigen::Index>(i);
    const Splat splat = splatOf(surfels.normals.col(column), surfels.radii[column], colors[i]);
    std::memcpy(cloud.records.data() + i * sizeof splat, &splat, sizeof splat);
  }
  CloudWriter writer(path, places.size(), cloud.fields, false);
  writer.write(cloud);
  writer.finish();
}

}  // namespace cloud_colorizer
