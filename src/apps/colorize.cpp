// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause

/// colorize RECORDING --output map.ply [name=value ...]
#include "apps/color_and_save.hpp"

int main(int argc, char** argv) {
  using namespace cloud_colorizer;
  CommandSpec spec;
  spec.program = "colorize";
  spec.summary = "Colours a recording and saves the map. What an interrupted run finished is used again.";
  spec.positionals = "RECORDING";
  spec.min_positionals = spec.max_positionals = 1;
  spec.options = {{"output", "FILE", "the coloured map, .ply, .pcd or .las", true}};
  addOutputOptions(spec);
  return runMain(argc, argv, spec, [](const CommandLine& line, const Callbacks& callbacks) {
    checkOutputs(line);
    requireColored(colorAndSave(Recording::open(line.positionals[0]), line, callbacks));
  });
}
