// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause

/// colorize_map --cloud map.ply --images DIR --model COLMAP_TEXT_DIR --output colored.ply [name=value ...]
#include <filesystem>

#include "apps/color_and_save.hpp"
#include "apps/recording_folder.hpp"
#include "base/param_text.hpp"
#include "base/text.hpp"
#include "cloud_colorizer/exchange/colmap.hpp"
#include "cloud_colorizer/exchange/import_model.hpp"

namespace cloud_colorizer {
namespace {

/// Of --kind KIND[:NAME[:SCALE[:OFFSET]]]. Throws UsageError.
Quantity quantityOf(const CommandLine& line) {
  if (!line.has("kind")) return {};
  const std::vector<std::string> parts = splitAt(line.option("kind"), ':');
  try {
    Quantity quantity;
    require<std::invalid_argument>(parts.size() <= 4, "it has ", parts.size(), " parts");
    quantity.kind = parseValue<ImageKind>("KIND", parts.at(0));
    if (quantity.kind == ImageKind::kColor) return {};
    quantity.name = quantity.kind == ImageKind::kRadiometric ? "temperature" : "label";
    if (parts.size() > 1) quantity.name = parts[1];
    if (parts.size() > 2) quantity.scale = parseNumber("SCALE", parts[2]);
    if (parts.size() > 3) quantity.offset = parseNumber("OFFSET", parts[3]);
    quantity.names = line.option("label-names");
    quantity.check();
    return quantity;
  } catch (const std::invalid_argument& error) {
    throw UsageError("--kind " + line.option("kind") + ": " + error.what());
  }
}

}  // namespace
}  // namespace cloud_colorizer

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
      {"kind", "KIND[:NAME[:SCALE[:OFFSET]]]",
       "what the images show: color, radiometric:temperature:0.01:-273.15 (value = scale * number + offset; NAME is "
       "the field of the map), labels or logits",
       false},
      {"labels", "DIR",
       "folder of the classes of the images' pixels beside their colours: NAME.png (numbers of classes) or NAME.npy "
       "(rows x columns x classes, scores or probabilities) for the image NAME",
       false},
      {"label-names", "FILE", "what the classes are; is kept beside the map", false},
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
        importModel({line.option("cloud"), line.option("images"), line.option("model"), line.option("masks"),
                     quantityOf(line), line.option("labels"), line.option("label-names")},
                    scratch.path(), line.params.record, callbacks);
    scratch.setWhole();
    auto names = writes_model ? namesOfViews(readColmapModel(line.option("model"))) : std::vector<std::string>{};
    if (writes_model) names.resize(recording.views().size());  // labels come after the photos
    const ColorizeSummary summary = colorAndSave(recording, line, callbacks, names);
    scratch.setDone();
    requireColored(summary);
  });
}
