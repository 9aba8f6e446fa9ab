// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause

/// Checks that throw with the name and the value of what is wrong, and what would be right.
#pragma once

#include <sstream>
#include <stdexcept>
#include <string>

namespace cloud_colorizer {

/// Thrown when Callbacks::cancelled asked a task to stop. Finished units of work stay on disk.
struct Cancelled : std::runtime_error {
  Cancelled() : std::runtime_error("cancelled") {}
};

/// Throws Error with all arguments streamed into one message, unless `condition` holds.
template <class Error = std::runtime_error, class... Args>
void require(bool condition, const Args&... args) {
  if (condition) return;
  std::ostringstream message;
  (message << ... << args);
  throw Error(message.str());
}

/// Throws std::invalid_argument unless low <= value <= high (false for NaN).
template <class T>
void requireInRange(const char* name, T value, T low, T high) {
  require<std::invalid_argument>(value >= low && value <= high, "parameter ", name, " = ", value, " must lie in [", low,
                                 ", ", high, "]");
}

}  // namespace cloud_colorizer
