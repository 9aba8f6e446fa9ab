// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause

#include "ros/map_job.hpp"

#include <ros/console.h>

#include <cmath>
#include <filesystem>
#include <stdexcept>
#include <utility>

#include "cloud_colorizer/base/check.hpp"
#include "cloud_colorizer/map/colorize.hpp"
#include "report/report.hpp"
#include "ros/node_log.hpp"

namespace cloud_colorizer {

Callbacks MapJob::callbacks(const Aborted& aborted) {
  Callbacks callbacks;
  callbacks.log = logLine;
  callbacks.cancelled = aborted;
  callbacks.progress = [this](const Progress& progress) {
    {
      const std::lock_guard<std::mutex> lock(state_mutex_);
      status_.progress = progress;
    }
    const double percent =
        progress.total > 0 ? 100.0 * static_cast<double>(progress.done) / static_cast<double>(progress.total) : 0;
    ROS_INFO_STREAM_THROTTLE_NAMED(
        5, "progress",
        progress.stage << ": " << static_cast<int>(percent) << " %, " << static_cast<long>(progress.points_per_second)
                       << " points/s, "
                       << (progress.seconds_left < 0 ? std::string("time left unknown")
                                                     : std::to_string(std::lround(progress.seconds_left)) + " s left"));
  };
  return callbacks;
}

JobResult MapJob::run(const std::string& what, const std::function<std::string(const Callbacks&)>& job,
                      const Aborted& aborted) {
  const std::unique_lock<std::mutex> alone(job_mutex_, std::try_to_lock);
  if (!alone.owns_lock()) {
    return {false, "the map is being coloured or saved (" + status().progress.stage + "); try again when that is done"};
  }
  {
    const std::lock_guard<std::mutex> lock(state_mutex_);
    status_.running = true;
    status_.progress = {};
    status_.progress.stage = what;
  }
  JobResult result;
  try {
    result = {true, job(callbacks(aborted))};
    ROS_INFO_STREAM(what << ": " << result.message);
  } catch (const Cancelled&) {
    result = {false, "cancelled"};
    ROS_WARN_STREAM(what << ": cancelled");
  } catch (const std::exception& error) {
    result = {false, error.what()};
    ROS_ERROR_STREAM(what << ": " << error.what());
  }
  const std::lock_guard<std::mutex> lock(state_mutex_);
  status_.running = false;
  status_.message = result.message;
  return result;
}

std::string MapJob::color(const Recording& recording, const Callbacks& callbacks) {
  std::vector<std::string> warnings;
  Callbacks noting = callbacks;
  noting.log = [&](LogLevel level, const std::string& text) {
    if (level == LogLevel::kWarning) warnings.push_back(text);
    callbacks.log(level, text);
  };
  const ColorizeSummary summary = cloud_colorizer::colorize(recording, params_, noting);
  {
    const std::lock_guard<std::mutex> lock(state_mutex_);
    status_.num_colored = summary.num_colored;
    colored_ = recording;
    summary_ = summary;
    warnings_ = std::move(warnings);
  }
  publish_(recording, params_);
  return summary.describe();
}

/// A recording only grows.
bool MapJob::isColored(const Recording& recording) const {
  const std::lock_guard<std::mutex> lock(state_mutex_);
  return colored_ && colored_->numPoints() == recording.numPoints() &&
         colored_->views().size() == recording.views().size();
}

JobResult MapJob::colorize(const Snapshot& snapshot, const Aborted& aborted) {
  return run(
      "colour", [&](const Callbacks& callbacks) { return color(snapshot(), callbacks); }, aborted);
}

JobResult MapJob::save(const Snapshot& snapshot, const std::function<std::string()>& path, const Aborted& aborted) {
  const auto job = [&](const Callbacks& callbacks) {
    const Recording recording = snapshot();
    if (!isColored(recording)) ROS_INFO_STREAM(color(recording, callbacks));
    const std::string file = path();
    const std::size_t num_points = saveColored(recording, params_, file, callbacks);
    return std::to_string(num_points) + " points written to " + file +
           (with_report_ ? report(recording, file, callbacks) : "");
  };
  return run("save", job, aborted);
}

std::string MapJob::reportFolder(const std::string& map) {
  const std::filesystem::path path(map);
  return (path.parent_path() / path.stem()).string() + "_report";
}

std::string MapJob::report(const Recording& recording, const std::string& map, const Callbacks& callbacks) const {
  RunFacts run;
  {
    const std::lock_guard<std::mutex> lock(state_mutex_);
    run.summary = summary_;
    run.warnings = warnings_;
  }
  run.name = std::filesystem::path(map).filename().string();
  run.program = "colorizer_node " CLOUD_COLORIZER_VERSION;
  const std::string folder = reportFolder(map);
  try {
    writeReport(recording, params_, run, folder, callbacks);
    return ", its report to " + folder;
  } catch (const std::runtime_error& error) {  // the map is there all the same
    ROS_ERROR_STREAM("the report in " << folder << " is not written: " << error.what());
    return ", but no report: " + std::string(error.what());
  }
}

JobStatus MapJob::status() const {
  const std::lock_guard<std::mutex> lock(state_mutex_);
  return status_;
}

std::optional<std::unique_lock<std::mutex>> MapJob::reserve() {
  std::unique_lock<std::mutex> lock(job_mutex_, std::try_to_lock);
  if (!lock.owns_lock()) return std::nullopt;
  return lock;
}

void MapJob::forget() {
  const std::lock_guard<std::mutex> lock(state_mutex_);
  colored_.reset();
  status_ = {};
}

}  // namespace cloud_colorizer
