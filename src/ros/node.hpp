// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause

/// The node: records topics, colours the recording when asked, publishes and saves the map.
///
/// Threads: one takes messages (sensor queue) into an inbox, one records them, encoders compress raw images, four serve
/// services and timers. Colouring runs in the thread of the service call, or after silence in one of its own, while
/// recording goes on.
#pragma once

#include <ros/node_handle.h>

#include <functional>
#include <memory>
#include <string>

#include "cloud_colorizer/ros/params.hpp"

namespace cloud_colorizer {

class ColorizerNode {
 public:
  /// Opens the recording and subscribes. Throws when a path cannot be used or the recording does not fit.
  ColorizerNode(const ros::NodeHandle& node, const ros::NodeHandle& private_node, const AllParams& params);
  ~ColorizerNode();

  /// Stops recording; with ~save_path set the map is coloured and saved. `aborted` is polled: true gives up.
  /// False when something could not be recorded, or the map was asked for and is not there; what was recorded stays in
  /// any case.
  bool finish(const std::function<bool()>& aborted);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace cloud_colorizer
