// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause

/// Counts finished work of one stage, reports it a few times a second, and carries the wish to stop.
#pragma once

#include <chrono>
#include <mutex>
#include <string>
#include <utility>

#include "cloud_colorizer/base/check.hpp"
#include "cloud_colorizer/base/types.hpp"

namespace cloud_colorizer {

class ProgressMeter {
 public:
  using Clock = std::chrono::steady_clock;

  ProgressMeter(const Callbacks& callbacks, std::string stage, std::size_t total) : callbacks_(callbacks) {
    progress_.stage = std::move(stage);
    progress_.total = total;
    report();
  }

  /// Counts `amount` as done; throws Cancelled when the caller wants to stop. `work` is false for what was found
  /// finished already: it does not count for the speed. Safe to call from several threads.
  void add(std::size_t amount, bool work = true) {
    const std::lock_guard<std::mutex> lock(mutex_);
    if (callbacks_.cancelled && callbacks_.cancelled()) throw Cancelled();
    progress_.done += amount;
    if (work) worked_ += amount;
    const double seconds = std::chrono::duration<double>(Clock::now() - start_).count();
    if (seconds > 0 && worked_ > 0) {
      progress_.points_per_second = static_cast<double>(worked_) / seconds;
      progress_.seconds_left = static_cast<double>(progress_.total - progress_.done) / progress_.points_per_second;
    }
    const bool last = progress_.done >= progress_.total;
    if (last || Clock::now() - reported_ > std::chrono::milliseconds(200)) report();
  }

 private:
  void report() {
    reported_ = Clock::now();
    if (callbacks_.progress) callbacks_.progress(progress_);
  }

  const Callbacks& callbacks_;
  std::mutex mutex_;
  Progress progress_;
  std::size_t worked_ = 0;
  Clock::time_point start_ = Clock::now(), reported_ = start_;
};

}  // namespace cloud_colorizer
