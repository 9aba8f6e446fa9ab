// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause
#include "ros/recording_session.hpp"

#include <chrono>
#include <filesystem>
#include <utility>

#include "cloud_colorizer/base/check.hpp"

namespace cloud_colorizer {

RecordingSession::RecordingSession(const std::string& directory, const CollectorParams& params, CollectorEvents events,
                                   ErrorLog& errors)
    : directory_(directory),
      params_(params),
      errors_(errors),
      recorder_(std::make_unique<Recorder>(directory, params.map_frame, params.record)),
      collector_(std::make_unique<Collector>(*recorder_, params, std::move(events))),
      thread_([this] { work(); }) {}

RecordingSession::~RecordingSession() {
  stop();
}

void RecordingSession::work() {
  while (!inbox_.closed()) {
    const auto task = inbox_.pop(std::chrono::milliseconds(100));
    const std::lock_guard<std::mutex> lock(mutex_);
    record(task);
  }
  const std::lock_guard<std::mutex> lock(mutex_);
  complete_ = !isGone();
  // What fails is out of its queue, so this ends.
  while (error_.empty() && errors_.guard("recording", [this] {
    collector_->finish();
    recorder_->flush();
  })) {
    complete_ = false;
    if (collector_->numPending() == 0) return;
  }
}

void RecordingSession::record(const std::optional<Inbox::Task>& task) {
  if (!error_.empty()) return;  // told once; nothing can be recorded
  try {
    if (task) (*task)(*collector_);
    collector_->process();
  } catch (const std::exception& error) {
    if (!isGone()) errors_.note("recording", error.what());
  }
}

/// Whether somebody deleted or moved the directory; it is told once.
bool RecordingSession::isGone() {
  if (error_.empty() && !recorder_->isInPlace()) {
    error_ =
        "the recording " + directory_ + " was deleted or moved away: nothing is recorded until ~reset begins a new one";
    errors_.note("recording", error_);
  }
  return !error_.empty();
}

Recording RecordingSession::snapshot() {
  const std::lock_guard<std::mutex> lock(mutex_);
  require(!isGone(), error_);
  collector_->settle();
  return recorder_->snapshot();
}

SessionState RecordingSession::state() {
  const std::lock_guard<std::mutex> lock(mutex_);
  isGone();
  return {recorder_->numPoints(), recorder_->numViews(), collector_->numPending(), collector_->stats(), error_};
}

std::optional<Eigen::Vector3d> RecordingSession::origin() {
  const std::lock_guard<std::mutex> lock(mutex_);
  const bool has_one = recorder_->numPoints() + recorder_->numViews() > 0;
  if (!origin_ && has_one && !isGone()) origin_ = recorder_->snapshot().origin();
  return origin_;
}

std::string RecordingSession::startAnew() {
  const std::lock_guard<std::mutex> lock(mutex_);
  std::string kept;
  if (recorder_->isInPlace()) {
    collector_->drain();
    recorder_->flush();
    kept = setAside(directory_);
  }
  try {
    auto fresh = std::make_unique<Recorder>(directory_, params_.map_frame, params_.record);
    collector_->useRecorder(*fresh);
    recorder_ = std::move(fresh);
  } catch (...) {
    if (!kept.empty()) {
      std::error_code ignored;
      std::filesystem::remove_all(directory_, ignored);
      std::filesystem::rename(kept, directory_);
    }
    throw;
  }
  origin_.reset();
  error_.clear();
  return kept;
}

bool RecordingSession::stop() {
  inbox_.close();
  if (thread_.joinable()) thread_.join();
  return complete_;
}

}  // namespace cloud_colorizer
