// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause

/// Lets as many pieces of work run at once as their memory fits.
#pragma once

#include <condition_variable>
#include <mutex>

namespace cloud_colorizer {

class MemoryBudget {
 public:
  explicit MemoryBudget(double max_bytes) : max_bytes_(max_bytes) {}

  /// Holds `bytes` of the budget while it lives; waits for them first. What exceeds the whole budget runs alone.
  class Share {
   public:
    Share(MemoryBudget& budget, double bytes) : budget_(budget), bytes_(bytes) {
      std::unique_lock<std::mutex> lock(budget_.mutex_);
      budget_.freed_.wait(lock,
                          [&] { return budget_.num_shares_ == 0 || budget_.used_ + bytes_ <= budget_.max_bytes_; });
      ++budget_.num_shares_;
      budget_.used_ += bytes_;
    }
    ~Share() {
      {
        const std::lock_guard<std::mutex> lock(budget_.mutex_);
        --budget_.num_shares_;
        budget_.used_ -= bytes_;
      }
      budget_.freed_.notify_all();
    }
    Share(const Share&) = delete;
    Share& operator=(const Share&) = delete;

   private:
    MemoryBudget& budget_;
    double bytes_;
  };

 private:
  double max_bytes_, used_ = 0;
  int num_shares_ = 0;
  std::mutex mutex_;
  std::condition_variable freed_;
};

}  // namespace cloud_colorizer
