// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause
#include "cloud_colorizer/map/colorize.hpp"

#include <utility>

#include "base/stop_watch.hpp"
#include "cloud_colorizer/base/check.hpp"
#include "map/parts.hpp"
#include "map/stages.hpp"
#include "map/summary.hpp"

namespace cloud_colorizer {

const std::vector<Stage>& allStages() {
  static const std::vector<Stage> kStages = {imageStage(),     movingStage(), surfelStage(),
                                             alignmentStage(), depthStage(),  colorStage()};
  return kStages;
}

void requireColorable(const Recording& recording) {
  require(recording.numPoints() > 0, "recording ", recording.directory(),
          " has no points; was the cloud topic published, and is there tf from its frame to the map?");
  require(!recording.views().empty(), "recording ", recording.directory(),
          " has no views; were images and camera_info published, and is there tf from the camera to the map?");
}

ColorizeSummary colorize(const Recording& recording, const Params& params, const Callbacks& callbacks) {
  StopWatch watch;
  params.check();
  requireColorable(recording);

  const FolderLock lock(recording.directory(), true);
  Workspace work(recording, params, true);
  if (params.colorize.memory_limit == 0 && callbacks.log) {
    const auto megabytes = static_cast<long>(work.memory().limit() / 1e6);
    callbacks.log(LogLevel::kInfo, "memory_limit: " + std::to_string(megabytes) + " MB");
  }
  std::vector<StageCost> costs;
  for (const Stage& stage : allStages()) {
    const std::size_t num_units = stage.units(work).size();
    if (num_units == 0) continue;
    StopWatch wall;
    ProcessorWatch processor;
    work.files().claim(stage.folder, stage.key(work));
    stage.run(work, {0, num_units}, callbacks);
    if (stage.handOn) stage.handOn(work, callbacks);
    costs.push_back({stage.name, wall.lap(), processor.lap(), MemoryPlan::peakMegabytes()});
  }
  ColorizeSummary summary = summarize(work);
  summary.stages = std::move(costs);
  summary.seconds = watch.lap();
  return summary;
}

}  // namespace cloud_colorizer
