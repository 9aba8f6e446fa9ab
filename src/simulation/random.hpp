// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause

/// Random numbers without state: a hash of what they are for, so that the same number comes out in any order of work.
#pragma once

#include <cmath>
#include <cstdint>

namespace cloud_colorizer::simulation {

/// The finaliser of splitmix64.
constexpr std::uint64_t mixBits(std::uint64_t x) {
  x += 0x9E3779B97F4A7C15ULL;
  x = (x ^ (x >> 30)) * 0xBF58476D1CE4E5B9ULL;
  x = (x ^ (x >> 27)) * 0x94D049BB133111EBULL;
  return x ^ (x >> 31);
}

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

/// Of mean 0 and standard deviation 1 (Box and Muller).
inline double gaussian(std::uint64_t key) {
  constexpr double kTwoPi = 6.283185307179586;
  return std::sqrt(-2 * std::log(1 - uniform(key))) * std::cos(kTwoPi * uniform(~key));
}

/// Three gaussian numbers of one key, from a table of 4096 quantiles: cheap enough for every pixel.
void gaussianTriple(std::uint64_t key, float* triple);

/// Smooth noise in [0, 1] over the plane, with features of about 1 unit.
float valueNoise(float x, float y, std::uint32_t seed);

}  // namespace cloud_colorizer::simulation
