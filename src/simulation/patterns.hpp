// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause

/// Filtered building blocks of the patterns. Private to the simulation library.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "simulation/material.hpp"
#include "simulation/random.hpp"

namespace cloud_colorizer::simulation {

inline float clamp01(float x) {
  return std::min(1.F, std::max(0.F, x));
}

/// Share of a window of `footprint` around x that lies above `edge`.
inline float above(float x, float edge, float footprint) {
  return clamp01((x - edge) / footprint + 0.5F);
}

/// Share of that window inside [low, high].
inline float inside(float x, float low, float high, float footprint) {
  return std::max(0.F, above(x, low, footprint) - above(x, high, footprint));
}

/// Share inside a rectangle.
inline float insideRect(float u, float v, float u0, float v0, float u1, float v1, float footprint) {
  return inside(u, u0, u1, footprint) * inside(v, v0, v1, footprint);
}

inline Color blend(const Color& under, const Color& over, float share) {
  return under + (over - under) * share;
}

/// Noise around zero, in [-1, 1], that fades away where its features are finer than the footprint.
inline float fadedNoise(float u, float v, float feature, std::uint32_t seed, float footprint) {
  const float fade = clamp01(1.5F - footprint / feature);
  return fade <= 0 ? 0.F : fade * (2 * valueNoise(u / feature, v / feature, seed) - 1);
}

/// A number in [0, 1) for a cell of a pattern.
inline float cellRandom(int i, int j, std::uint32_t seed) {
  return static_cast<float>(uniform(keyOf(i, j, seed)));
}

/// Share of ink of `text` (5 x 7 cells a letter, 6 to the next) at (u, v), metres from its lower left corner.
float letteringInk(const char* text, float u, float v, float letter_height, float footprint);

/// Width of the text [m].
float letteringWidth(const char* text, float letter_height);

Color facadeAlbedo(const Material& material, const FacePoint& point);
Color groundAlbedo(const Material& material, const FacePoint& point);

}  // namespace cloud_colorizer::simulation
