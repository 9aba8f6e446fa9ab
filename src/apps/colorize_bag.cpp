// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause

/// colorize_bag DRIVE.bag [DRIVE2.bag ...] --output map.ply [--config rig.yaml] [--recording DIR] [name=value ...]
#include <ros/time.h>

#include "apps/bag_recording.hpp"
#include "apps/color_and_save.hpp"
#include "apps/recording_folder.hpp"
#include "cloud_colorizer/ros/params.hpp"

namespace cloud_colorizer {
namespace {

CommandSpec commandSpec() {
  CommandSpec spec;
  spec.program = "colorize_bag";
  spec.summary = "Colours the map of one or more bags. Needs no roscore.";
  spec.positionals = "DRIVE.bag [DRIVE2.bag ...]";
  spec.min_positionals = 1;
  spec.max_positionals = 100000;
  spec.options = {{"output", "FILE", "the coloured map, .ply, .pcd or .las", true},
                  kConfigOption,
                  kPosesOption,
                  kPosesFrameOption,
                  {"recording", "DIR", "keep the recording here; `colorize DIR` colours it again", false}};
  addOutputOptions(spec);
  spec.other_params = describeCollectorParams(CollectorParams());
  return spec;
}

void run(const CommandLine& line, const Callbacks& callbacks) {
  checkOutputs(line);
  RecordingFolder scratch(line.option("recording"), line.option("output"), callbacks);
  recordBags(line, line.positionals, scratch.path(), {}, callbacks);
  const Recording recording = Recording::open(scratch.path());
  if (recording.numPoints() > 0 && !recording.views().empty()) scratch.setWhole();  // else it can colour nothing
  const ColorizeSummary summary = colorAndSave(recording, line, callbacks);
  scratch.setDone();
  requireColored(summary);
}

}  // namespace
}  // namespace cloud_colorizer

int main(int argc, char** argv) {
  ros::Time::init();
  return cloud_colorizer::runMain(argc, argv, cloud_colorizer::commandSpec(), cloud_colorizer::run);
}
