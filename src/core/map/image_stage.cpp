// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
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

std::vector<double> imageUnits(const Workspace& work) {
  std::vector<double> units(work.files().numViewBlocks());
  for (std::size_t block = 0; block < units.size(); ++block) {
    units[block] = static_cast<double>(work.files().viewsOfBlock(block).size());
  }
  return units;
}

UnitFiles imageFiles(const Workspace& work) {
  UnitFiles files;
  for (std::size_t block = 0; block < work.files().numViewBlocks(); ++block) {
    files.push_back({DerivedFiles::nameOfView(block)});
  }
  return files;
}

ViewList findDamaged(Workspace& work, std::size_t block, ProgressMeter& progress) {
  ViewList damaged;
  for (const std::uint32_t view : work.files().viewsOfBlock(block)) {
    if (!faultOf(work, view).empty()) damaged.push_back(view);
    progress.add(1);
  }
  return damaged;
}

void checkImages(Workspace& work, UnitRange blocks, const Callbacks& callbacks) {
  const DerivedFiles& files = work.files();
  std::vector<std::size_t> todo;
  std::size_t num_views = 0;
  for (std::size_t block = blocks.first; block < blocks.last; ++block) {
    if (files.readDamagedViews(block)) continue;
    todo.push_back(block);
    num_views += files.viewsOfBlock(block).size();
  }
  if (todo.empty()) return;
  ProgressMeter progress(callbacks, "check images", num_views);
  parallelFor(work.params().colorize.num_threads, todo.size(),
              [&](std::size_t k) { files.writeDamagedViews(todo[k], findDamaged(work, todo[k], progress)); });
}

/// Leaves the damaged ones out, and names them in the log.
void leaveOutDamaged(Workspace& work, const Callbacks& callbacks) {
  require(work.restoreDamagedViews(), "what was found of the images of ", work.recording().directory(),
          " is not whole; colour it again");
  for (const std::uint32_t view : work.damagedViews()) {
    const std::string fault = faultOf(work, view);
    require(!work.usableViews().empty(), "no image of the recording ", work.recording().directory(),
            " can be used: ", fault);
    if (callbacks.log) callbacks.log(LogLevel::kWarning, "a view is left out: " + fault);
  }
}

}  // namespace

Stage imageStage() {
  return {"images",   "blocks of views", kImageCheckFolder,
          {},         imageUnits,        [](const Workspace& work) { return imageFilesKey(work.recording()); },
          imageFiles, checkImages,       leaveOutDamaged};
}

}  // namespace cloud_colorizer
