// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause

#include "ros/node_output.hpp"

#include <cloud_colorizer/ColorizeStatus.h>
#include <sensor_msgs/PointCloud2.h>
#include <unistd.h>

#include <algorithm>
#include <fstream>

#include "cloud_colorizer/map/colorize.hpp"
#include "cloud_colorizer/ros/conversions.hpp"
#include "ros/preview.hpp"

namespace cloud_colorizer {
namespace {

constexpr std::size_t kMaxMessageBytes = 900000000;  // subscribers refuse messages above 1 GB

/// Resident memory of this process, MB.
double residentMegabytes() {
  std::ifstream file("/proc/self/statm");
  double total = 0, resident = 0;
  file >> total >> resident;
  return resident * static_cast<double>(sysconf(_SC_PAGESIZE)) / 1e6;
}

std::vector<Eigen::Index> everyKth(Eigen::Index count, std::size_t stride, std::size_t& seen) {
  std::vector<Eigen::Index> kept;
  for (Eigen::Index i = 0; i < count; ++i, ++seen) {
    if (seen % stride == 0) kept.push_back(i);
  }
  return kept;
}

/// Of one topic: what became of its messages. Returns what is wrong, or nothing.
std::string addStream(const std::string& name, const StreamStats& stream,
                      diagnostic_updater::DiagnosticStatusWrapper& status) {
  for (std::size_t i = 0; i < stream.outcomes.size(); ++i) {
    if (stream.outcomes[i] > 0) status.add(name + " " + toString(static_cast<Outcome>(i)), stream.outcomes[i]);
  }
  if (!stream.last_error.empty()) status.add(name + " last error", stream.last_error);
  const bool records = stream.received == 0 || stream.count(Outcome::kKept) > 0 || stream.last_error.empty();
  return records ? "" : name + ": nothing recorded: " + stream.last_error;
}

}  // namespace

void logLine(LogLevel level, const std::string& text) {
  if (level == LogLevel::kError) {
    ROS_ERROR_STREAM(text);
  } else if (level == LogLevel::kWarning) {
    ROS_WARN_STREAM(text);
  } else {
    ROS_INFO_STREAM(text);
  }
}

NodeOutput::NodeOutput(const ros::NodeHandle& node, const ros::NodeHandle& private_node, const NodeParams& params)
    : params_(params), diagnostics_(node, private_node) {
  ros::NodeHandle out(node), private_out(private_node);
  map_ = out.advertise<sensor_msgs::PointCloud2>("colored_map", 1, true);
  preview_ = out.advertise<sensor_msgs::PointCloud2>("colored_map_preview", 1, true);
  path_ = out.advertise<nav_msgs::Path>("camera_path", 1, true);
  status_ = private_out.advertise<ColorizeStatus>("status", 10, true);
  diagnostics_.setHardwareID("none");
  diagnostics_.add("recording", this, &NodeOutput::diagnose);
}

std::string NodeOutput::frameFor(const Eigen::Vector3d& origin) {
  const std::string& map_frame = params_.collector.map_frame;
  if (origin.isZero()) return map_frame;
  std::string frame = map_frame + "_origin";
  const std::lock_guard<std::mutex> lock(frame_mutex_);
  if (announced_ && *announced_ == origin) return frame;
  geometry_msgs::TransformStamped transform;
  transform.header.stamp = ros::Time::now();
  transform.header.frame_id = map_frame;
  transform.child_frame_id = frame;
  transform.transform.translation.x = origin.x();
  transform.transform.translation.y = origin.y();
  transform.transform.translation.z = origin.z();
  transform.transform.rotation.w = 1;
  broadcaster_.sendTransform(transform);
  announced_ = std::make_unique<Eigen::Vector3d>(origin);
  return frame;
}

void NodeOutput::publishPath(nav_msgs::Path path) {
  path.header.frame_id = params_.collector.map_frame;
  path.header.stamp = ros::Time::now();
  path_.publish(path);
}

void NodeOutput::publishPreview(const Cloud& cloud, const Eigen::Vector3d& origin) {
  sensor_msgs::PointCloud2Ptr message(new sensor_msgs::PointCloud2);
  message->header.frame_id = frameFor(origin);
  message->header.stamp = ros::Time::now();
  appendToMessage(cloud, *message);
  preview_.publish(message);
}

void NodeOutput::publishMap(const Recording& recording, const Params& params) {
  const std::size_t total = recording.numPoints();
  const std::size_t step = 12 + recordSize(coloredFields(recording, params));
  const std::size_t cap = std::min(static_cast<std::size_t>(params_.max_published_points), kMaxMessageBytes / step);
  const std::size_t stride = std::max<std::size_t>(1, (total + cap - 1) / cap);
  sensor_msgs::PointCloud2Ptr message(new sensor_msgs::PointCloud2);
  message->data.reserve((total / stride + 1) * step);
  VoxelThinner thinner(kPreviewVoxelSize, kMaxPreviewPoints);
  std::size_t seen = 0;
  forEachColoredTile(recording, params, true, [&](const Cloud& tile) {
    thinner.add(tile);
    if (stride == 1) {
      appendToMessage(tile, *message);
    } else {
      appendToMessage(selectPoints(tile, everyKth(tile.positions.cols(), stride, seen)), *message);
    }
  });
  message->header.frame_id = frameFor(recording.origin());
  message->header.stamp = ros::Time::now();
  if (stride > 1) {
    ROS_INFO_STREAM("colored_map carries " << message->width << " of " << total << " points (every " << stride
                                           << "th): ~max_published_points is " << params_.max_published_points
                                           << "; ~save_map writes them all");
  }
  map_.publish(message);
  publishPreview(thinner.cloud(), recording.origin());
}

void NodeOutput::publishStatus(const NodeState& state) {
  const JobStatus& job = state.job;
  ColorizeStatus status;
  status.header.stamp = ros::Time::now();
  status.header.frame_id = params_.collector.map_frame;
  status.stage = job.running ? job.progress.stage : state.stage;
  status.seconds_left = -1;
  if (job.running) {
    status.done = job.progress.done;
    status.total = job.progress.total;
    status.points_per_second = job.progress.points_per_second;
    status.seconds_left = job.progress.seconds_left;
  }
  status.points = state.session.points;
  status.views = state.session.views;
  status.colored_points = job.num_colored;
  status.message = state.session.error.empty() ? job.message : state.session.error;
  status_.publish(status);
  const std::lock_guard<std::mutex> lock(diagnostics_mutex_);
  state_ = state;
  diagnostics_.update();
}

void NodeOutput::diagnose(diagnostic_updater::DiagnosticStatusWrapper& status) {
  using diagnostic_msgs::DiagnosticStatus;
  const SessionState& session = state_.session;
  std::string trouble;
  const auto notice = [&trouble](const std::string& text) {
    if (!text.empty()) trouble = text;
  };
  for (const auto& topic : state_.topics) {
    status.add(topic.topic + " rate [Hz]", topic.rate);
    status.add(topic.topic + " messages", topic.messages);
    if (topic.dropped == 0) continue;
    status.add(topic.topic + " dropped", topic.dropped);
    notice("messages were dropped: recording is too slow");
  }
  notice(addStream("clouds", session.stats.cloud, status));
  for (std::size_t i = 0; i < session.stats.cameras.size(); ++i) {
    notice(addStream("camera_" + std::to_string(i), session.stats.cameras[i], status));
  }
  for (const auto& [place, row] : state_.errors) {
    status.add(place + " errors", row.count);
    status.add(place + " last error", row.last);
    notice(place + ": " + row.last);
  }
  status.add("last tf failure", session.stats.last_tf_error);
  status.add("time jumps", session.stats.time_jumps);
  status.add("waiting messages", session.pending);
  status.add("points", session.points);
  status.add("views", session.views);
  status.add("colored points", state_.job.num_colored);
  status.add("memory [MB]", residentMegabytes());
  status.add("recording", state_.directory);
  if (state_.job.running) status.add("colouring", state_.job.progress.stage);
  status.summary(trouble.empty() ? DiagnosticStatus::OK : DiagnosticStatus::WARN,
                 trouble.empty() ? state_.stage : trouble);
  if (!session.error.empty()) status.summary(DiagnosticStatus::ERROR, session.error);
}

}  // namespace cloud_colorizer
