// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause
#include "ros/cloud_stream.hpp"

#include <limits>
#include <stdexcept>
#include <utility>

#include "cloud_colorizer/ros/conversions.hpp"
#include "ros/message_stamps.hpp"

namespace cloud_colorizer {
namespace {

std::string frameOf(const sensor_msgs::PointCloud2& message) {
  std::string frame = withoutSlash(message.header.frame_id);
  if (frame.empty()) throw Refused{Outcome::kMalformed, "the header's frame_id is empty"};
  return frame;
}

/// Many drivers give a beam without a return as (0, 0, 0).
void dropZeroReturns(Cloud& cloud) {
  for (Eigen::Index i = 0; i < cloud.positions.cols(); ++i) {
    if ((cloud.positions.col(i).array() == 0).all()) {
      cloud.positions.col(i).setConstant(std::numeric_limits<double>::quiet_NaN());
    }
  }
}

}  // namespace

CloudStream::CloudStream(const CollectorParams& params, const TransformBuffer& transforms, NearScanner near_scanner,
                         Say say, Kept kept)
    : transforms_(transforms),
      map_frame_(withoutSlash(params.map_frame)),
      sensor_frame_(withoutSlash(params.sensor_frame)),
      time_offset_(params.cloud_time_offset),
      near_scanner_(std::move(near_scanner)),
      say_(std::move(say)),
      kept_(std::move(kept)),
      deskewer_(params.deskew, [this](LogLevel level, const std::string& text) { say_(level, "deskew", text); }) {}

/// The frame from which ranges are measured. Mapping programs publish clouds that are in the map frame already: the
/// scanner's frame is then known by its name, or by what is near it.
std::string CloudStream::sensorOf(const std::string& frame) {
  std::string sensor = sensor_frame_.empty() ? frame : sensor_frame_;
  if (sensor != map_frame_) return sensor;
  std::string scanner = transforms_.scannerFrame();
  if (scanner.empty()) scanner = near_scanner_();
  if (scanner.empty()) return sensor;
  say_(LogLevel::kWarning, "range",
       "the clouds are in the map frame already; they are taken as measured from the frame " + scanner +
           "; set sensor_frame where the scanner has another");
  return scanner;
}

/// The message's cloud in its own frame. Throws Refused.
Sweep CloudStream::readSweep(const sensor_msgs::PointCloud2& message) const {
  checkStamp(message.header);
  const ros::Time stamp = shiftedStamp(message.header.stamp, time_offset_);
  const std::string frame = frameOf(message);
  Sweep sweep;
  sweep.stamp = message.header.stamp.toSec();
  sweep.pose = [this, frame, stamp](double seconds) {
    return transforms_.lookUp(map_frame_, frame, shiftedStamp(stamp, seconds));
  };
  try {
    sweep.cloud = cloudFromMessage(message);
  } catch (const std::invalid_argument& error) {
    throw Refused{Outcome::kMalformed, error.what()};
  }
  if (frame != map_frame_) dropZeroReturns(sweep.cloud);
  return sweep;
}

WaitingSweeps CloudStream::waitingSweeps() const {
  return {queue.size(), [this](std::size_t i) { return queue[i]->header.stamp.toSec(); },
          [this](std::size_t i) { return readSweep(*queue[i]); }};
}

Outcome CloudStream::record(bool may_wait, Recorder& recorder, Recorder::InsertCounts& points) {
  const sensor_msgs::PointCloud2& message = *queue.front();
  checkStamp(message.header);
  if (may_wait && deskewer_.waitsFor(queue.back()->header.stamp.toSec())) throw NotYet{{Outcome::kNoTransform, ""}};
  const ros::Time stamp = shiftedStamp(message.header.stamp, time_offset_);
  const std::string frame = frameOf(message);
  const std::string sensor = sensorOf(frame);
  const Eigen::Isometry3d map_from_sensor = transforms_.lookUp(map_frame_, sensor, stamp);
  const Eigen::Isometry3d sensor_from_cloud = transforms_.lookUp(sensor, frame, stamp);
  Sweep sweep = readSweep(message);
  if (frame != map_frame_) deskewer_.apply(sweep, waitingSweeps(), may_wait);
  Cloud& cloud = sweep.cloud;
  if (sensor != frame) cloud.positions = sensor_from_cloud * cloud.positions;
  const CloudSource source = {frame, stamp.toSec()};
  const bool recorded_before = recorder.recognizeCloud(source);
  if (!recorded_before) count(recorder.addCloud(cloud, map_from_sensor, source), points);
  // Where only the neighbourhood of the scanner is known, its rays are not.
  const bool is_scanner =
      sensor != map_frame_ && (frame != map_frame_ || sensor == sensor_frame_ || sensor == transforms_.scannerFrame());
  if (is_scanner) recorder.addScan(frame, source.stamp, cloud.positions, map_from_sensor);
  if (kept_) kept_(cloud, map_from_sensor, source.stamp);
  return recorded_before ? Outcome::kRecordedBefore : Outcome::kKept;
}

void CloudStream::count(const Recorder::InsertCounts& counts, Recorder::InsertCounts& points) const {
  points.added += counts.added;
  points.not_finite += counts.not_finite;
  points.too_near += counts.too_near;
  points.too_far += counts.too_far;
  points.voxel_taken += counts.voxel_taken;
  if (counts.fields_dropped.empty()) return;
  say_(LogLevel::kWarning, "fields",
       "field " + counts.fields_dropped.front() +
           " is not recorded: the first cloud of the recording had no such field");
}

}  // namespace cloud_colorizer
