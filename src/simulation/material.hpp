// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause

/// Procedural materials: the colour of a surface before light falls on it.
#pragma once

#include <Eigen/Core>
#include <cstdint>

namespace cloud_colorizer::simulation {

using Color = Eigen::Array3f;  ///< red, green, blue, 0 to 255

enum class Pattern {
  kPlain,
  kGround,  ///< asphalt with lane markings, lettering, manholes; yards beyond the pavements
  kPaving,
  kKerb,
  kFacade,
  kRoof,
  kCarBody,
  kCarCabin,
  kWheel,
  kBark,
  kLeaves,
  kSign,
  kBands,  ///< stripes of the two colours
};

struct Material {
  Pattern pattern = Pattern::kPlain;
  Color color = Color::Constant(128);
  Color accent = Color::Constant(200);
  std::uint32_t seed = 0;     ///< chooses style, layout and words
  float reflectivity = 0.4F;  ///< what the LiDAR sees beside the grey value, 0 to 1
};

/// A place on a face, seen from outside: u to the right, v up (metres, from the lower left corner of the face).
struct FacePoint {
  float u = 0, v = 0;
  float width = 1, height = 1;      ///< m, of the face
  Eigen::Vector3f normal{0, 0, 1};  ///< in the frame of the primitive
  Eigen::Vector3f local{0, 0, 0};   ///< m, in the frame of the primitive
  float footprint = 0.01F;          ///< m; what is finer than this is averaged
};

/// Colour of the material there, without light.
Color albedo(const Material& material, const FacePoint& point);

/// Half of the carriageway's width [m]; the kerb stands here. Shared by the ground's pattern and the street.
constexpr float kRoadHalfWidth = 5.0F;
constexpr float kLaneHalfWidth = 3.0F;  ///< m; parking bays lie beyond

}  // namespace cloud_colorizer::simulation
