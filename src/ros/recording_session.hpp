// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause

/// The node's recording: an inbox, the thread that records what is in it, and the change to a new recording.
/// Safe to use from several threads.
#pragma once

#include <Eigen/Core>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>

#include "cloud_colorizer/recording/recorder.hpp"
#include "cloud_colorizer/ros/collector.hpp"
#include "ros/inbox.hpp"
#include "ros/node_log.hpp"

namespace cloud_colorizer {

/// What is known about recording, for status and diagnostics.
struct SessionState {
  std::size_t points = 0, views = 0, pending = 0;
  CollectorStats stats;
  std::string error;  ///< why nothing is recorded any more; empty: all is well
};

class RecordingSession {
 public:
  /// Creates or continues the recording in `directory`. `events` come from the recording thread.
  RecordingSession(const std::string& directory, const CollectorParams& params, CollectorEvents events,
                   ErrorLog& errors);
  ~RecordingSession();

  const std::string& directory() const { return directory_; }
  /// False when `limit` messages of the stream wait already: the message is not taken.
  bool push(const std::string& stream, std::size_t limit, Inbox::Task task) {
    return inbox_.push(stream, limit, std::move(task));
  }
  Recording snapshot();  ///< what is recorded by now; throws when the directory is gone
  SessionState state();
  /// Of the recording; fixed by the first point or view.
  std::optional<Eigen::Vector3d> origin();

  /// Begins a new recording in the same directory. The old one, with all images that are being encoded, gets another
  /// name, which is returned; empty where it was gone. When it throws, the old recording goes on under its name.
  std::string startAnew();

  /// Records what has come and can be recorded. False when something of it could not be written.
  bool stop();

 private:
  void work();
  void record(const std::optional<Inbox::Task>& task);
  bool isGone();

  const std::string directory_;
  const CollectorParams params_;
  ErrorLog& errors_;
  Inbox inbox_;
  std::mutex mutex_;  ///< what follows, up to `complete_`
  std::unique_ptr<Recorder> recorder_;
  std::optional<Eigen::Vector3d> origin_;
  std::unique_ptr<Collector> collector_;
  std::string error_;
  bool complete_ = true;
  std::thread thread_;
};

/// `recording_dir`, or where it is empty a new directory $ROS_HOME/cloud_colorizer/<date and time> (ROS_HOME: ~/.ros).
std::string resolveRecordingDirectory(const std::string& recording_dir);

/// Renames a recording out of the way, to the same name with date and time; returns the new name.
std::string setAside(const std::string& directory);

}  // namespace cloud_colorizer
