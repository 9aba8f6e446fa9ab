// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause

/// colorize_bag DRIVE.bag [DRIVE2.bag ...] --output map.ply [--config rig.yaml] [--recording DIR] [name=value ...]
#include <ros/console.h>
#include <ros/time.h>

#include "apps/color_and_save.hpp"
#include "apps/recording_folder.hpp"
#include "cloud_colorizer/base/check.hpp"
#include "cloud_colorizer/recording/recorder.hpp"
#include "cloud_colorizer/ros/bag_source.hpp"
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
  spec.options = {
      {"output", "FILE", "the coloured map, .ply or .pcd", true},
      {"config", "FILE",
       "rig file: which topic is what; without it a bag that can be read in one way only is understood", false},
      {"recording", "DIR", "keep the recording here; `colorize DIR` colours it again", false},
      kWriteModelOption};
  spec.other_params = describeCollectorParams(CollectorParams());
  return spec;
}

CollectorParams collectorParams(const CommandLine& line, const Rig& rig) {
  CollectorParams params;
  params.record = line.params.record;
  if (!rig.map_frame.empty()) params.map_frame = rig.map_frame;
  params.cameras.clear();
  for (const RigCamera& camera : rig.cameras) params.cameras.push_back(camera.params);
  std::map<std::string, std::string> texts = line.others;
  try {
    takeCollectorParams(texts, params);
    params.check();
  } catch (const std::invalid_argument& error) {
    throw UsageError(error.what());
  }
  require<UsageError>(texts.empty(), "unknown parameter ", texts.empty() ? "" : texts.begin()->first, "; there are ",
                      rig.cameras.size(), " cameras");
  return params;
}

void record(const CommandLine& line, const std::string& directory, const Callbacks& callbacks) {
  BagSource bags(line.positionals);
  const Rig rig = line.has("config") ? readRig(line.option("config"), bags.topics()) : guessRig(bags.topics());
  callbacks.log(LogLevel::kInfo, describeRig(rig));
  const CollectorParams params = collectorParams(line, rig);
  Recorder recorder(directory, params.map_frame, params.record);
  CollectorEvents events;
  events.log = callbacks.log;
  Collector collector(recorder, params, events);
  bags.play(rig, params.tf_wait, collector, callbacks);
  recorder.flush();
  callbacks.log(LogLevel::kInfo, collector.stats().describe());
}

void run(const CommandLine& line, const Callbacks& callbacks) {
  checkOutputs(line);
  RecordingFolder scratch(line.option("recording"), line.option("output"), callbacks);
  record(line, scratch.path(), callbacks);
  const Recording recording = Recording::open(scratch.path());
  if (recording.numPoints() > 0 && !recording.views().empty()) scratch.setWhole();  // else it can colour nothing
  colorAndSave(recording, line, callbacks);
  scratch.setDone();
}

}  // namespace
}  // namespace cloud_colorizer

int main(int argc, char** argv) {
  ros::Time::init();
  return cloud_colorizer::runMain(argc, argv, cloud_colorizer::commandSpec(), cloud_colorizer::run);
}
