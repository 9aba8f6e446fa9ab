// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause

/// Time of one stage after another.
#pragma once

#include <chrono>
#include <ctime>
#include <utility>

namespace cloud_colorizer {

/// Processor time of all threads of this process: what else the machine does matters little to it.
struct ProcessorClock {
  using duration = std::chrono::duration<double>;
  using time_point = std::chrono::time_point<ProcessorClock, duration>;

  static time_point now() {
    return time_point(duration(static_cast<double>(std::clock()) / static_cast<double>(CLOCKS_PER_SEC)));
  }
};

template <class Clock>
class BasicStopWatch {
 public:
  /// Seconds since the last call, or since the watch was made.
  double lap() {
    const auto now = Clock::now();
    return std::chrono::duration<double>(now - std::exchange(start_, now)).count();
  }

 private:
  typename Clock::time_point start_ = Clock::now();
};

using StopWatch = BasicStopWatch<std::chrono::steady_clock>;
using ProcessorWatch = BasicStopWatch<ProcessorClock>;

}  // namespace cloud_colorizer
