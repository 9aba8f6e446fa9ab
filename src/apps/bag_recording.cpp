// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause
#include "apps/bag_recording.hpp"

#include "cloud_colorizer/base/check.hpp"
#include "cloud_colorizer/recording/recorder.hpp"
#include "cloud_colorizer/ros/bag_source.hpp"
#include "cloud_colorizer/ros/params.hpp"

namespace cloud_colorizer {
namespace {

constexpr double kLatePoses = 10;  // s

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

}  // namespace

const OptionSpec kConfigOption = {
    "config", "FILE", "rig file: which topic is what; without it a bag that can be read in one way only is understood",
    false};

const OptionSpec kPosesOption = {
    "poses", "FILE", "poses of the vehicle in the map, instead of tf's: TUM (stamp x y z qx qy qz qw) or KITTI", false};

const OptionSpec kPosesFrameOption = {"poses-frame", "FRAME",
                                      "whose poses --poses gives; without it, those of the cloud's frame", false};

void recordBags(const CommandLine& line, const std::vector<std::string>& bags, const std::string& directory,
                CollectorEvents events, const Callbacks& callbacks) {
  BagSource source(bags);
  const auto format_of = [&](const std::string& topic) { return source.formatOf(topic); };
  Rig rig = line.has("config") ? readRig(line.option("config"), source.topics()) : guessRig(source.topics(), format_of);
  if (line.has("poses-frame")) rig.base_frame = line.option("poses-frame");
  if (!line.has("poses")) source.addOdometry(rig);
  const CollectorParams params = collectorParams(line, rig);
  if (line.has("poses")) source.addPoses(line.option("poses"), params.map_frame, rig);
  callbacks.log(LogLevel::kInfo, describeRig(rig));
  Recorder recorder(directory, params.map_frame, params.record);
  events.log = callbacks.log;
  Collector collector(recorder, params, std::move(events));
  // A bag can be read ahead: poses that were published some seconds after their moment cost nothing here.
  source.play(rig, params.tf_wait + kLatePoses, collector, callbacks);
  recorder.flush();
  const CollectorStats& stats = collector.stats();
  callbacks.log(LogLevel::kInfo, stats.describe());
  require<NothingColored>(recorder.numPoints() > 0, stats.whyNoPoints());
  require<NothingColored>(recorder.numViews() > 0, stats.whyNoViews());
}

}  // namespace cloud_colorizer
