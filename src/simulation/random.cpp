// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause

#include "simulation/random.hpp"

namespace cloud_colorizer::simulation {
namespace {

float latticeValue(std::int32_t x, std::int32_t y, std::uint32_t seed) {
  std::uint32_t h = static_cast<std::uint32_t>(x) * 0x85EBCA6BU ^ static_cast<std::uint32_t>(y) * 0xC2B2AE35U ^ seed;
  h = (h ^ (h >> 15)) * 0x2C1B3C6DU;
  h = (h ^ (h >> 12)) * 0x297A2D39U;
  return static_cast<float>((h ^ (h >> 15)) >> 8) * 0x1.0p-24F;
}

}  // namespace

void gaussianTriple(std::uint64_t key, float* triple) {
  static const std::vector<float> kTable = normalQuantiles(4096);
  const std::uint64_t bits = mixBits(key);
  triple[0] = kTable[bits & 4095];
  triple[1] = kTable[(bits >> 12) & 4095];
  triple[2] = kTable[(bits >> 24) & 4095];
}

float valueNoise(float x, float y, std::uint32_t seed) {
  const float floor_x = std::floor(x);
  const float floor_y = std::floor(y);
  const auto i = static_cast<std::int32_t>(floor_x);
  const auto j = static_cast<std::int32_t>(floor_y);
  float a = x - floor_x;
  float b = y - floor_y;
  a = a * a * (3 - 2 * a);
  b = b * b * (3 - 2 * b);
  const float low = latticeValue(i, j, seed) * (1 - a) + latticeValue(i + 1, j, seed) * a;
  const float high = latticeValue(i, j + 1, seed) * (1 - a) + latticeValue(i + 1, j + 1, seed) * a;
  return low * (1 - b) + high * b;
}

}  // namespace cloud_colorizer::simulation
