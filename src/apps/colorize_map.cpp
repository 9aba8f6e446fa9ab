// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause

/// colorize_map --cloud map.ply --images DIR --model COLMAP_TEXT_DIR --output colored.ply [name=value ...]
#include "cloud_colorizer/colorize.hpp"
#include "cloud_colorizer/import_model.hpp"
#include "cloud_colorizer/io.hpp"
#include "command_line.hpp"
#include "recording_folder.hpp"

int main(int argc, char** argv) {
  using namespace cloud_colorizer;
  CommandSpec spec;
  spec.program = "colorize_map";
  spec.summary = "Colours a cloud from images with known cameras and poses (COLMAP text model).";
  spec.options = {{"cloud", "FILE", "the map, .ply or .pcd", true},
                  {"images", "DIR", "folder of the images that the model names", true},
                  {"model", "DIR", "folder with cameras.txt and images.txt", true},
                  {"output", "FILE", "the coloured map, .ply or .pcd", true},
                  {"recording", "DIR", "keep the recording here instead of in a temporary folder", false}};
  // A finished map: every point is wanted, and nothing is known about its scale or about where it was measured from.
  spec.defaults.record.voxel_size = 0;
  spec.defaults.depth.max_view_distance = 1e6;
  return runMain(argc, argv, spec, [](const CommandLine& line, const Callbacks& callbacks) {
    const std::string output = line.option("output");
    CloudWriter::checkPath(output);
    const RecordingFolder scratch(line.option("recording"), output);
    const Recording recording = importModel({line.option("cloud"), line.option("images"), line.option("model")},
                                            scratch.path(), line.params.record, callbacks);
    const ColorizeSummary summary = colorize(recording, line.params, callbacks);
    callbacks.log(LogLevel::kInfo, summary.describe());
    saveColored(recording, line.params, output, callbacks);
    callbacks.log(LogLevel::kInfo, "saved " + output);
  });
}
