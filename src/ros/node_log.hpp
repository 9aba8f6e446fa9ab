// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause

/// What the node logs: lines of the core, lines that come often, errors of callbacks, services and timers.
#pragma once

#include <ros/console.h>

#include <chrono>
#include <exception>
#include <map>
#include <mutex>
#include <optional>
#include <string>

#include "cloud_colorizer/base/types.hpp"

namespace cloud_colorizer {

/// A line of the core's log on the ROS console.
void logLine(LogLevel level, const std::string& text);

/// Lets a line of a kind through at most every ten seconds, and counts those it holds back.
class LineThrottle {
 public:
  /// Empty: the line is held back. Else what to append to it: "" or " (and 3 more like this)".
  std::optional<std::string> pass(const std::string& kind) {
    Line& line = lines_[kind];
    const auto now = std::chrono::steady_clock::now();
    if (line.used && now - line.last < std::chrono::seconds(10)) {
      ++line.left_out;
      return std::nullopt;
    }
    std::string suffix;
    if (line.left_out > 0) suffix = " (and " + std::to_string(line.left_out) + " more like this)";
    line = {true, 0, now};
    return suffix;
  }

 private:
  struct Line {
    bool used = false;
    std::size_t left_out = 0;
    std::chrono::steady_clock::time_point last;
  };
  std::map<std::string, Line> lines_;
};

/// Errors by the place where they were caught: on the console, throttled, and counted for the diagnostics. ROS ends the
/// program on what a callback throws, so each runs in guard(). Safe to use from several threads.
class ErrorLog {
 public:
  void note(const std::string& place, const std::string& text) {
    std::optional<std::string> suffix;
    {
      const std::lock_guard<std::mutex> lock(mutex_);
      Row& row = rows_[place];
      ++row.count;
      row.last = text;
      suffix = throttle_.pass(place);
    }
    if (suffix) ROS_ERROR_STREAM(place << ": " << text << *suffix);
  }

  /// Runs `body` and notes what it throws; the error's text, or nothing when it went well.
  template <class Body>
  std::optional<std::string> guard(const std::string& place, const Body& body) {
    try {
      body();
      return std::nullopt;
    } catch (const std::exception& error) {
      note(place, error.what());
      return error.what();
    }
  }

  struct Row {
    std::size_t count = 0;
    std::string last;
  };
  std::map<std::string, Row> rows() const {
    const std::lock_guard<std::mutex> lock(mutex_);
    return rows_;
  }

 private:
  mutable std::mutex mutex_;
  LineThrottle throttle_;
  std::map<std::string, Row> rows_;
};

}  // namespace cloud_colorizer
