// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause

/// The report of a coloured map: report.html, one page to open from disk, and report.json with the same numbers.
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "cloud_colorizer/base/types.hpp"
#include "cloud_colorizer/map/colorize.hpp"

namespace cloud_colorizer {

/// What the run knows that the recording does not.
struct RunFacts {
  ColorizeSummary summary;
  std::vector<std::string> warnings;
  std::string name;                  ///< of the map or its recording, without a path
  std::string program;               ///< "colorize_bag 0.3.0"
  std::vector<std::string> command;  ///< as it was given; with folders where the user wants them told
  std::size_t max_points = 400'000;  ///< of the map in the page
};

/// Writes both files into `directory`, which is made when missing, after colorize() with these parameters. Goes once
/// through the map. Returns what report.json holds; doc/report.schema.json tells its names. Throws as
/// forEachColoredTile(); std::runtime_error where a file cannot be written.
nlohmann::json writeReport(const Recording& recording, const Params& params, const RunFacts& run,
                           const std::string& directory, const Callbacks& callbacks);

/// A condition on a number of report.json: "map.colored_share<0.9", with < or >. True where it holds. Throws
/// std::invalid_argument where there is no such number, or the text is no condition.
bool holds(const std::string& condition, const nlohmann::json& report);

}  // namespace cloud_colorizer
