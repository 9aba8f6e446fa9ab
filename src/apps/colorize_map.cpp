// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause

/// colorize_map --cloud map.ply --images DIR --model COLMAP_TEXT_DIR --output colored.ply [name=value ...]
#include <filesystem>

#include "apps/color_and_save.hpp"
#include "apps/recording_folder.hpp"
#include "cloud_colorizer/exchange/colmap.hpp"
#include "cloud_colorizer/exchange/import_model.hpp"

int main(int argc, char** argv) {
  using namespace cloud_colorizer;
  CommandSpec spec;
  spec.program = "colorize_map";
  spec.summary = "Colours a cloud from images with known cameras and poses (COLMAP model).";
  spec.options = {
      {"cloud", "FILE", "the map, .ply, .pcd or .las", true},
      {"images", "DIR", "folder of the images that the model names", true},
      {"model", "DIR", "folder of a COLMAP model, binary or text (also the folder around its sparse/0)", true},
      {"masks", "DIR", "folder of masks, NAME.png for the image NAME, black where it must not colour", false},
      {"output", "FILE", "the coloured map, .ply, .pcd or .las", true},
      {"recording", "DIR", "keep the recording here instead of in a temporary folder", false}};
  addOutputOptions(spec);
  // A finished map: every point is wanted.
  spec.defaults.record.voxel_size = 0;
  return runMain(argc, argv, spec, [](const CommandLine& line, const Callbacks& callbacks) {
    checkOutputs(line);
    std::error_code ignored;
    const bool writes_model = line.has(kWriteModelOption.name);
    if (writes_model &&
        std::filesystem::equivalent(line.option(kWriteModelOption.name), line.option("model"), ignored)) {
      throw UsageError("--write-model would replace the --model that is read; give it another folder");
    }
    RecordingFolder scratch(line.option("recording"), line.option("output"), callbacks);
    const Recording recording =
        importModel({line.option("cloud"), line.option("images"), line.option("model"), line.option("masks")},
                    scratch.path(), line.params.record, callbacks);
    scratch.setWhole();
    const auto names = writes_model ? namesOfViews(readColmapModel(line.option("model"))) : std::vector<std::string>{};
    const ColorizeSummary summary = colorAndSave(recording, line, callbacks, names);
    scratch.setDone();
    requireColored(summary);
  });
}
