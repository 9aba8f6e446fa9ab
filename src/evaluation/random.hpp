// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause

/// Counter-based random numbers: a number is a function of (seed, index), so any thread can draw any of them.
#pragma once

#include <cmath>
#include <cstdint>

namespace cloud_colorizer {

/// A well mixed 64-bit hash of (seed, index): two rounds of splitmix64's finaliser.
inline std::uint64_t hash64(std::uint64_t seed, std::uint64_t index) {
  const auto mix = [](std::uint64_t x) {
    x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9ULL;
    x = (x ^ (x >> 27)) * 0x94d049bb133111ebULL;
    return x ^ (x >> 31);
  };
  return mix(mix(seed + 0x9e3779b97f4a7c15ULL) + (index + 1) * 0x9e3779b97f4a7c15ULL);
}

/// Uniform in the open interval (0, 1).
inline double uniform(std::uint64_t seed, std::uint64_t index) {
  return (static_cast<double>(hash64(seed, index) >> 11) + 0.5) * 0x1p-53;
}

/// Standard normal, by Box and Muller.
inline double gaussian(std::uint64_t seed, std::uint64_t index) {
  constexpr double kTwoPi = 6.283185307179586;
  return std::sqrt(-2 * std::log(uniform(seed, 2 * index))) * std::cos(kTwoPi * uniform(seed, 2 * index + 1));
}

}  // namespace cloud_colorizer
