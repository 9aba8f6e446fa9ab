// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause
#include <stdexcept>

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
  } catch (const std::runtime_error& error) {
    return error.what();
  }
}

ViewList findDamagedViews(Workspace& work, const Callbacks& callbacks) {
  const std::size_t num_views = work.recording().views().size();
  std::vector<char> is_damaged(num_views);
  ProgressMeter progress(callbacks, "check images", num_views);
  parallelFor(work.params().colorize.num_threads, num_views, [&](std::size_t view) {
    is_damaged[view] = !faultOf(work, view).empty();
    progress.add(1);
  });
  ViewList damaged;
  for (std::uint32_t view = 0; view < num_views; ++view) {
    if (is_damaged[view]) damaged.push_back(view);
  }
  return damaged;
}

}  // namespace

void checkImages(Workspace& work, const Callbacks& callbacks) {
  if (!work.restoreDamagedViews()) {
    ViewList damaged = findDamagedViews(work, callbacks);
    work.files().claim(kImageCheckFolder, imageFilesKey(work.recording()));
    work.files().writeDamagedViews(damaged);
    work.leaveOut(std::move(damaged));
  }
  for (const std::uint32_t view : work.damagedViews()) {
    const std::string fault = faultOf(work, view);
    require(!work.usableViews().empty(), "no image of the recording ", work.recording().directory(),
            " can be used: ", fault);
    if (callbacks.log) callbacks.log(LogLevel::kWarning, "a view is left out: " + fault);
  }
}

}  // namespace cloud_colorizer
