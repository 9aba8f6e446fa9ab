// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause

/// Counter-based random numbers: a number is a function of (seed, index), so any thread can draw any of them.
#pragma once

#include "base/random.hpp"

namespace cloud_colorizer {

/// A well mixed 64-bit hash of (seed, index).
inline std::uint64_t hash64(std::uint64_t seed, std::uint64_t index) {
  return mixBits(mixBits(seed) + index * 0x9e3779b97f4a7c15ULL);
}

/// Uniform in the open interval (0, 1).
inline double uniform(std::uint64_t seed, std::uint64_t index) {
  return (static_cast<double>(hash64(seed, index) >> 11) + 0.5) * 0x1p-53;
}

inline double gaussian(std::uint64_t seed, std::uint64_t index) {
  return gaussianOf(uniform(seed, 2 * index), uniform(seed, 2 * index + 1));
}

}  // namespace cloud_colorizer
