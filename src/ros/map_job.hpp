// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause

/// Colouring and saving, one at a time; a second request is refused with the reason. Safe to use from several threads.
#pragma once

#include <functional>
#include <mutex>
#include <optional>
#include <string>

#include "cloud_colorizer/recording/recording.hpp"
#include "ros/node_output.hpp"

namespace cloud_colorizer {

struct JobResult {
  bool success = false;
  std::string message;
};

class MapJob {
 public:
  using Aborted = std::function<bool()>;

  MapJob(const AllParams& params, NodeOutput& output) : params_(params), output_(output) {}

  /// Colours what `snapshot` returns, and publishes it.
  JobResult colorize(const std::function<Recording()>& snapshot, const Aborted& aborted);
  /// Saves what was coloured last.
  JobResult save(const std::string& path, const Aborted& aborted);

  bool hasMap() const;
  std::size_t numColored() const;
  JobStatus status() const;
  /// Keeps jobs away while the result lives; empty while one is running.
  std::optional<std::unique_lock<std::mutex>> reserve();
  void forget();  ///< there is no map any more

 private:
  JobResult run(const std::string& what, const std::function<std::string(const Callbacks&)>& job,
                const Aborted& aborted);
  Callbacks callbacks(const Aborted& aborted);

  const AllParams& params_;
  NodeOutput& output_;
  std::mutex job_mutex_;            ///< held by the running job
  mutable std::mutex state_mutex_;  ///< what follows
  JobStatus status_;
  std::optional<Recording> colored_;
};

}  // namespace cloud_colorizer
