// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause

/// colorize RECORDING --output map.ply [name=value ...]
#include "cloud_colorizer/colorize.hpp"

#include "cloud_colorizer/export_model.hpp"
#include "cloud_colorizer/io.hpp"
#include "cloud_colorizer/recording.hpp"
#include "command_line.hpp"

int main(int argc, char** argv) {
  using namespace cloud_colorizer;
  CommandSpec spec;
  spec.program = "colorize";
  spec.summary = "Colours a recording and saves the map. What an interrupted run finished is used again.";
  spec.positionals = "RECORDING";
  spec.min_positionals = spec.max_positionals = 1;
  spec.options = {{"output", "FILE", "the coloured map, .ply or .pcd", true}, kWriteModelOption};
  return runMain(argc, argv, spec, [](const CommandLine& line, const Callbacks& callbacks) {
    const std::string output = line.option("output");
    CloudWriter::checkPath(output);
    prepareModelFolder(line);
    const Recording recording = Recording::open(line.positionals[0]);
    const ColorizeSummary summary = colorize(recording, line.params, callbacks);
    callbacks.log(LogLevel::kInfo, summary.describe());
    saveColored(recording, line.params, output, callbacks);
    callbacks.log(LogLevel::kInfo, "saved " + output);
    if (line.has("write-model")) exportModel(recording, line.params, line.option("write-model"));
  });
}
