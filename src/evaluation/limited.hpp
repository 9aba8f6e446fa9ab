// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause

/// A computation in a process of its own, with limits, so that it can be stopped and its memory measured.
#pragma once

#include <cstring>
#include <functional>
#include <string>

#include "cloud_colorizer/base/check.hpp"

namespace cloud_colorizer {

struct Limits {
  double seconds = 60;      ///< of a processor; fifty times as long by the clock on the wall
  double megabytes = 8000;  ///< beyond what the caller has in use
};

struct LimitedRun {
  std::string status;         ///< "ok", "time limit", "memory limit", or the message of an exception
  std::string bytes;          ///< what `body` returned; empty unless ok
  double seconds = 0;         ///< of a processor
  double peak_megabytes = 0;  ///< largest resident memory, of the child alone
};

/// Runs `body` in a forked child. No other thread may hold a lock at the time, and `body` may not rely on threads of
/// the caller. Throws std::runtime_error when no process can be made.
LimitedRun runLimited(const std::function<std::string()>& body, const Limits& limits);

/// Plain values as bytes for a LimitedRun, one after the other.
template <class T>
void appendBytes(std::string& bytes, const T* values, std::size_t count) {
  bytes.append(reinterpret_cast<const char*>(values), count * sizeof(T));
}
/// And back: the values at `at`, which comes to stand behind them.
template <class T>
void takeBytes(const std::string& bytes, std::size_t& at, T* values, std::size_t count) {
  require(at + count * sizeof(T) <= bytes.size(), "a result from a child process is cut off");
  std::memcpy(values, bytes.data() + at, count * sizeof(T));
  at += count * sizeof(T);
}

}  // namespace cloud_colorizer
