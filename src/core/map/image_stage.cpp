// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause
#include <exception>

#include "base/parallel.hpp"
#include "base/progress.hpp"
#include "cloud_colorizer/base/check.hpp"
#include "map/fingerprint.hpp"
#include "map/stages.hpp"

namespace cloud_colorizer {
namespace {

/// Why the image of a view cannot be used; empty when it can.
std::string faultOf(Workspace& work, std::size_t view) {
  try {
    work.image(view);
    return "";
  } catch (const std::exception& error) {
    return error.what();
  }
}

std::vector<DamagedView> findDamagedViews(Workspace& work, const Callbacks& callbacks) {
  const std::size_t num_views = work.recording().views().size();
  std::vector<std::string> faults(num_views);
  ProgressMeter progress(callbacks, "check images", num_views);
  parallelFor(work.params().colorize.num_threads, num_views, [&](std::size_t view) {
    faults[view] = faultOf(work, view);
    progress.add(1);
  });
  std::vector<DamagedView> damaged;
  for (std::size_t view = 0; view < num_views; ++view) {
    if (!faults[view].empty()) damaged.push_back({static_cast<std::uint32_t>(view), faults[view]});
  }
  return damaged;
}

}  // namespace

void checkImages(Workspace& work, const Callbacks& callbacks) {
  if (!work.restoreDamagedViews()) {
    std::vector<DamagedView> damaged = findDamagedViews(work, callbacks);
    work.files().claim(kImageCheckFolder, imageFilesKey(work.recording()));
    work.files().writeDamagedViews(damaged);
    work.leaveOut(std::move(damaged));
  }
  for (const DamagedView& damaged : work.damagedViews()) {
    require(!work.usableViews().empty(), "no image of the recording ", work.recording().directory(),
            " can be used: ", damaged.reason);
    if (callbacks.log) callbacks.log(LogLevel::kWarning, "a view is left out: " + damaged.reason);
  }
}

}  // namespace cloud_colorizer
