// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause

/// Plain data that every stage shares: columns of points and values, boxes, callbacks.
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

namespace cloud_colorizer {

/// Positions, 3 x n, one column a point, in metres, in the map frame relative to the recording's origin.
using Points = Eigen::Matrix3Xf;
using PointsRef = Eigen::Ref<const Points>;

/// Values, m x n, one column a point. Colours are m = 3 in the order red, green, blue, on the scale 0 to 255.
using Values = Eigen::MatrixXf;
using ValuesRef = Eigen::Ref<const Values>;

/// How far a long task has come. `unit` says what is counted ("points", "views").
struct Progress {
  std::string stage;
  std::size_t done = 0;
  std::size_t total = 0;
  double points_per_second = 0;
  double seconds_left = -1;  ///< s; negative while unknown
};

/// A parameter for people: name, value as text, what it is.
struct ParamText {
  std::string name, value, help;
};

enum class LogLevel { kInfo, kWarning, kError };

/// How the core talks to the outside. Every member may be empty. They are called from one thread at a time.
struct Callbacks {
  std::function<void(const Progress&)> progress;
  std::function<void(LogLevel, const std::string&)> log;
  std::function<bool()> cancelled;  ///< polled between units of work; true makes the task throw Cancelled
};

}  // namespace cloud_colorizer
