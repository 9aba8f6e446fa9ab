// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause

/// Statistics that single wrong values do not move.
#pragma once

#include <algorithm>
#include <vector>

namespace cloud_colorizer {

/// Median of a copy of the values, of an even number the upper one; 0 of none.
template <class Number>
Number median(std::vector<Number> values) {
  if (values.empty()) return 0;
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

/// From the median magnitude of normal errors to their standard deviation.
constexpr double kMadToSigma = 1.4826;

/// Standard deviation of normal errors with these magnitudes, `least` at least.
inline float robustSigma(std::vector<float> magnitudes, float least) {
  return std::max(least, static_cast<float>(kMadToSigma) * median(std::move(magnitudes)));
}

/// Cauchy weight 1 / (1 + (r / (2.385 scale))^2): outliers fade, and never become certain to be so.
inline float cauchyWeight(float residual, float scale) {
  const float x = residual / (2.385F * scale);
  return 1 / (1 + x * x);
}

}  // namespace cloud_colorizer
