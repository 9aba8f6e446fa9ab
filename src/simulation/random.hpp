// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause

/// Random numbers of a key.
#pragma once

#include "base/random.hpp"

namespace cloud_colorizer::simulation {

/// One key of any number of integers; their order matters.
template <class... Integers>
constexpr std::uint64_t keyOf(Integers... integers) {
  std::uint64_t key = 0;
  ((key = mixBits(key ^ static_cast<std::uint64_t>(integers))), ...);
  return key;
}

/// In [0, 1).
inline double uniform(std::uint64_t key) {
  return static_cast<double>(mixBits(key) >> 11) * 0x1.0p-53;
}

inline double uniform(std::uint64_t key, double low, double high) {
  return low + (high - low) * uniform(key);
}

inline double gaussian(std::uint64_t key) {
  return gaussianOf(1 - uniform(key), uniform(~key));
}

/// Three gaussian numbers of one key, from a table of 4096 quantiles: cheap enough for every pixel.
void gaussianTriple(std::uint64_t key, float* triple);

/// Smooth noise in [0, 1] over the plane, with features of about 1 unit.
float valueNoise(float x, float y, std::uint32_t seed);

}  // namespace cloud_colorizer::simulation
