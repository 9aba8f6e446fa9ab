// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause

/// Colouring and saving, one at a time; a second request is refused with the reason. Safe to use from several threads.
#pragma once

#include <functional>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "cloud_colorizer/base/types.hpp"
#include "cloud_colorizer/map/colorize.hpp"
#include "cloud_colorizer/map/params.hpp"
#include "cloud_colorizer/recording/recording.hpp"

namespace cloud_colorizer {

struct JobResult {
  bool success = false;
  std::string message;
};

/// What is known about colouring.
struct JobStatus {
  bool running = false;
  Progress progress;
  std::size_t num_colored = 0;
  std::string message;  ///< result of the last job
};

class MapJob {
 public:
  using Aborted = std::function<bool()>;
  using Snapshot = std::function<Recording()>;
  /// Gets every map that was coloured.
  using Publish = std::function<void(const Recording&, const Params&)>;

  /// `with_report`: a report is written beside every map that is saved, into a folder reportFolder().
  MapJob(const Params& params, Publish publish, bool with_report = false)
      : params_(params), publish_(std::move(publish)), with_report_(with_report) {}

  /// Colours what `snapshot` returns, and publishes it.
  JobResult colorize(const Snapshot& snapshot, const Aborted& aborted);
  /// The same, where there is something new since the last map; then saves it. `path` is called just before the map is
  /// written, and gives the file's name or throws.
  JobResult save(const Snapshot& snapshot, const std::function<std::string()>& path, const Aborted& aborted);

  JobStatus status() const;
  /// Keeps jobs away while the result lives; empty while one is running.
  std::optional<std::unique_lock<std::mutex>> reserve();
  void forget();  ///< there is no map any more

  /// drive_report, of drive.ply.
  static std::string reportFolder(const std::string& map);

 private:
  using Job = std::function<std::string(const Callbacks&)>;

  JobResult run(const std::string& what, const Job& job, const Aborted& aborted);
  std::string color(const Recording& recording, const Callbacks& callbacks);
  /// Where it was written, or why not, as the end of a sentence.
  std::string report(const Recording& recording, const std::string& map, const Callbacks& callbacks) const;
  bool isColored(const Recording& recording) const;
  Callbacks callbacks(const Aborted& aborted);

  const Params params_;
  const Publish publish_;
  const bool with_report_;
  std::mutex job_mutex_;            ///< held by the running job
  mutable std::mutex state_mutex_;  ///< what follows
  JobStatus status_;
  std::optional<Recording> colored_;
  ColorizeSummary summary_;            ///< of it
  std::vector<std::string> warnings_;  ///< of its colouring
};

}  // namespace cloud_colorizer
