// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause

/// The clouds of a topic on their way into a recording: where each was measured from, and its motion undone.
#pragma once

#include <deque>
#include <functional>
#include <string>

#include "cloud_colorizer/ros/collector.hpp"
#include "ros/camera_stream.hpp"
#include "ros/deskew.hpp"
#include "ros/transform_buffer.hpp"

namespace cloud_colorizer {

class CloudStream {
 public:
  using Kept = std::function<void(const Cloud&, const Eigen::Isometry3d& map_from_sensor, double stamp)>;
  /// A frame that is near the scanner; empty: none is known.
  using NearScanner = std::function<std::string()>;

  /// `kept` may be empty.
  CloudStream(const CollectorParams& params, const TransformBuffer& transforms, NearScanner near_scanner, Say say,
              Kept kept);

  /// Of the first in the queue. Throws NotYet, where it `may_wait` also for clouds that show how the sensor moves;
  /// Refused.
  Outcome record(bool may_wait, Recorder& recorder, Recorder::InsertCounts& points);
  void startAnew() { deskewer_.startAnew(); }  ///< as time jumped back

  std::deque<sensor_msgs::PointCloud2ConstPtr> queue;

 private:
  std::string sensorOf(const std::string& frame);
  Sweep readSweep(const sensor_msgs::PointCloud2& message) const;
  WaitingSweeps waitingSweeps() const;
  void count(const Recorder::InsertCounts& counts, Recorder::InsertCounts& points) const;

  const TransformBuffer& transforms_;
  std::string map_frame_, sensor_frame_;
  double time_offset_;  ///< s
  NearScanner near_scanner_;
  Say say_;
  Kept kept_;
  Deskewer deskewer_;
};

}  // namespace cloud_colorizer
