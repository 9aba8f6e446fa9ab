// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause
#include "apps/color_and_save.hpp"

#include <filesystem>

#include "cloud_colorizer/base/check.hpp"
#include "cloud_colorizer/cloud/cloud_io.hpp"
#include "cloud_colorizer/exchange/export_model.hpp"
#include "cloud_colorizer/map/colorize.hpp"

namespace cloud_colorizer {

const OptionSpec kWriteModelOption = {"write-model", "DIR",
                                      "the corrected poses: COLMAP's text model, and a TUM trajectory a camera", false};

void checkOutputs(const CommandLine& line) {
  CloudWriter::checkPath(line.option("output"));
  if (!line.has(kWriteModelOption.name)) return;
  const std::string directory = line.option(kWriteModelOption.name);
  std::error_code error;
  std::filesystem::create_directories(directory, error);
  require(!error && std::filesystem::is_directory(directory), "cannot create the folder ", directory, " of --",
          kWriteModelOption.name, ": ", error ? error.message() : "it is a file");
}

void colorAndSave(const Recording& recording, const CommandLine& line, const Callbacks& callbacks,
                  const std::vector<std::string>& image_names) {
  const std::string output = line.option("output");
  // What the format cannot hold is told before the work.
  { const CloudWriter trial(output, 0, coloredFields(recording, line.params), false); }
  const ColorizeSummary summary = colorize(recording, line.params, callbacks);
  callbacks.log(LogLevel::kInfo, summary.describe());
  saveColored(recording, line.params, output, callbacks);
  callbacks.log(LogLevel::kInfo, "saved " + output);
  if (line.has(kWriteModelOption.name)) {
    exportModel(recording, line.params, line.option(kWriteModelOption.name), image_names);
  }
}

}  // namespace cloud_colorizer
