// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause

/// Between the subscribers and the thread that records: callbacks only put a message here and return.
#pragma once

#include <condition_variable>
#include <deque>
#include <functional>
#include <map>
#include <mutex>
#include <optional>
#include <string>
#include <utility>

#include "cloud_colorizer/ros/collector.hpp"

namespace cloud_colorizer {

class Inbox {
 public:
  using Task = std::function<void(Collector&)>;

  /// False when `limit` messages of the stream wait already: the message is not taken.
  bool push(const std::string& stream, std::size_t limit, Task task) {
    {
      const std::lock_guard<std::mutex> lock(mutex_);
      if (waiting_[stream] >= limit) return false;
      ++waiting_[stream];
      tasks_.emplace_back(stream, std::move(task));
    }
    wake_.notify_one();
    return true;
  }

  /// Waits up to `timeout` for a message. Empty when none came, or after close() when none is left.
  template <class Duration>
  std::optional<Task> pop(Duration timeout) {
    std::unique_lock<std::mutex> lock(mutex_);
    wake_.wait_for(lock, timeout, [this] { return closed_ || !tasks_.empty(); });
    if (tasks_.empty()) return std::nullopt;
    auto [stream, task] = std::move(tasks_.front());
    tasks_.pop_front();
    --waiting_[stream];
    return std::move(task);
  }

  void close() {
    {
      const std::lock_guard<std::mutex> lock(mutex_);
      closed_ = true;
    }
    wake_.notify_all();
  }

  bool closed() const {
    const std::lock_guard<std::mutex> lock(mutex_);
    return closed_ && tasks_.empty();
  }

 private:
  mutable std::mutex mutex_;
  std::condition_variable wake_;
  bool closed_ = false;
  std::map<std::string, std::size_t> waiting_;
  std::deque<std::pair<std::string, Task>> tasks_;
};

}  // namespace cloud_colorizer
