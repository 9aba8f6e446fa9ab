// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause

/// Random numbers without state: a hash of what they are for, so that the same number comes out in any order of work.
#pragma once

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace cloud_colorizer {

/// The finaliser of splitmix64.
constexpr std::uint64_t mixBits(std::uint64_t x) {
  x += 0x9e3779b97f4a7c15ULL;
  x = (x ^ (x >> 30U)) * 0xbf58476d1ce4e5b9ULL;
  x = (x ^ (x >> 27U)) * 0x94d049bb133111ebULL;
  return x ^ (x >> 31U);
}

/// Standard normal, of two uniform numbers, the first one not 0 (Box and Muller).
inline double gaussianOf(double first, double second) {
  constexpr double kTwoPi = 6.283185307179586;
  return std::sqrt(-2 * std::log(first)) * std::cos(kTwoPi * second);
}

/// Quantiles of the standard normal at (k + 0.5) / count, by bisection of erfc: a table for the noise of every pixel.
inline std::vector<float> normalQuantiles(std::size_t count) {
  std::vector<float> quantiles(count);
  for (std::size_t k = 0; k < count; ++k) {
    const double probability = (static_cast<double>(k) + 0.5) / static_cast<double>(count);
    double low = -6, high = 6;
    for (int i = 0; i < 50; ++i) {
      const double middle = (low + high) / 2;
      (0.5 * std::erfc(-middle / std::sqrt(2.0)) < probability ? low : high) = middle;
    }
    quantiles[k] = static_cast<float>((low + high) / 2);
  }
  return quantiles;
}

}  // namespace cloud_colorizer
