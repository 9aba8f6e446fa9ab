// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause

/// How often messages come, and which topics are silent. Safe to use from several threads.
#pragma once

#include <chrono>
#include <map>
#include <mutex>
#include <string>
#include <utility>
#include <vector>

namespace cloud_colorizer {

class TopicMonitor {
 public:
  using Clock = std::chrono::steady_clock;

  void watch(const std::string& topic) {
    const std::lock_guard<std::mutex> lock(mutex_);
    topics_[topic].last = Clock::now();
  }

  void count(const std::string& topic) {
    const std::lock_guard<std::mutex> lock(mutex_);
    Topic& state = topics_[topic];
    ++state.messages;
    state.last = Clock::now();
    state.told = false;
  }

  void countDropped(const std::string& topic) {
    const std::lock_guard<std::mutex> lock(mutex_);
    ++topics_[topic].dropped;
  }

  /// Topics that became silent for longer than `limit` since the last call.
  std::vector<std::string> newlySilent(std::chrono::seconds limit) {
    const std::lock_guard<std::mutex> lock(mutex_);
    std::vector<std::string> silent;
    for (auto& [name, topic] : topics_) {
      if (topic.told || Clock::now() - topic.last < limit) continue;
      topic.told = true;
      silent.push_back(name);
    }
    return silent;
  }

  /// s since the last message of any topic; negative when none has come.
  double secondsOfSilence() const {
    const std::lock_guard<std::mutex> lock(mutex_);
    double least = -1;
    for (const auto& [name, topic] : topics_) {
      if (topic.messages == 0) continue;
      const double seconds = std::chrono::duration<double>(Clock::now() - topic.last).count();
      if (least < 0 || seconds < least) least = seconds;
    }
    return least;
  }

  struct Report {
    std::string topic;
    double rate = 0;  ///< Hz since the last report
    std::size_t messages = 0, dropped = 0;
  };
  std::vector<Report> report() {
    const std::lock_guard<std::mutex> lock(mutex_);
    const auto now = Clock::now();
    const double seconds = std::chrono::duration<double>(now - reported_).count();
    reported_ = now;
    std::vector<Report> rows;
    for (auto& [name, topic] : topics_) {
      const auto since = static_cast<double>(topic.messages - topic.reported);
      rows.push_back({name, seconds > 0 ? since / seconds : 0, topic.messages, topic.dropped});
      topic.reported = topic.messages;
    }
    return rows;
  }

 private:
  struct Topic {
    std::size_t messages = 0, reported = 0, dropped = 0;
    Clock::time_point last;
    bool told = false;
  };
  mutable std::mutex mutex_;
  std::map<std::string, Topic> topics_;
  Clock::time_point reported_ = Clock::now();
};

}  // namespace cloud_colorizer
