// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause
#include "apps/color_and_save.hpp"

#include <algorithm>
#include <filesystem>
#include <map>
#include <sstream>

#include "base/text.hpp"
#include "cloud_colorizer/base/check.hpp"
#include "cloud_colorizer/cloud/cloud_io.hpp"
#include "cloud_colorizer/exchange/export_model.hpp"
#include "cloud_colorizer/map/colorize.hpp"

namespace cloud_colorizer {

const OptionSpec kWriteModelOption = {"write-model", "DIR",
                                      "the corrected poses: COLMAP's text model, and a TUM trajectory a camera", false};
const OptionSpec kUndistortOption = {"undistort", "",
                                     "with --write-model: the images as pinhole cameras would take them", false};
const OptionSpec kSplatsOption = {"splats", "FILE", "the map as Gaussian splats, .ply, at most two million", false};

const OptionSpec kTilesOption = {"tiles", "DIR",
                                 "the map also as files of at most two million points each, and tiles.json", false};
const OptionSpec kReportOption = {"report", "DIR", "report.html, to look at in a browser, and report.json", false};
const OptionSpec kFailIfOption = {
    "fail-if", "NAME<VALUE", "with --report: exit code 4 where it holds for a number of report.json, or NAME>VALUE",
    false};

void addOutputOptions(CommandSpec& spec) {
  for (const OptionSpec& option :
       {kTilesOption, kWriteModelOption, kUndistortOption, kSplatsOption, kReportOption, kFailIfOption}) {
    spec.options.push_back(option);
  }
}

void checkOutputs(const CommandLine& line) {
  CloudWriter::checkPath(line.option("output"));
  if (line.has(kSplatsOption.name)) {
    const std::string splats = line.option(kSplatsOption.name);
    if (lowerExtension(splats) != ".ply") throw UsageError("--splats " + splats + ": its extension must be .ply");
    CloudWriter::checkPath(splats);
  }
  require<UsageError>(!line.has(kFailIfOption.name) || line.has(kReportOption.name), "--fail-if needs --report");
  require<UsageError>(!line.has(kUndistortOption.name) || line.has(kWriteModelOption.name), "--undistort needs --",
                      kWriteModelOption.name, ", the folder of model and images");
  for (const OptionSpec& option : {kTilesOption, kWriteModelOption}) {
    if (!line.has(option.name)) continue;
    const std::string directory = line.option(option.name);
    std::error_code error;
    std::filesystem::create_directories(directory, error);
    require(!error && std::filesystem::is_directory(directory), "cannot create the folder ", directory, " of --",
            option.name, ": ", error ? error.message() : "it is a file");
  }
}

namespace {

/// A map whose views contradict each other as much as its points differ is painted with something else's colours.
/// Measured: drives 0.13, hand-held depth cameras 0.29, six cameras that share narrow strips only 0.48; nonsense 0.9.
constexpr double kMostDisagreement = 0.7;

void warnOfDisagreement(const ColorizeSummary& summary, const Callbacks& callbacks) {
  if (summary.disagreement < kMostDisagreement || !callbacks.log) return;
  std::ostringstream text;
  text.precision(2);
  text << "the views of a point differ from each other nearly as much as the points do (" << summary.disagreement
       << " of it, where right poses give less than 0.5): poses, calibration or clocks cannot be right. In a COLMAP "
       << "model, look at the order of the quaternions (w x y z), at their direction (camera from map), and whether "
       << "model and images belong together";
  callbacks.log(LogLevel::kWarning, text.str());
}

std::string describe(const StageCost& stage) {
  std::ostringstream text;
  text.precision(3);
  text << "the stage " << stage.name << " took " << stage.seconds << " s, " << stage.cpu_seconds
       << " s of a core; resident at the most so far " << static_cast<long>(stage.peak_megabytes) << " MB";
  return text.str();
}

/// What a colleague gets to see of a command: not where on this machine its files are.
std::string withoutFolders(const std::string& argument) {
  const std::size_t equals = argument.find('=');
  const std::size_t value = equals == std::string::npos ? 0 : equals + 1;
  const std::size_t slash = argument.rfind('/');
  if (slash == std::string::npos || slash < value) return argument;
  const std::string name = std::filesystem::path(argument.substr(value)).lexically_normal().filename().string();
  return argument.substr(0, value) + (name.empty() ? "..." : name);
}

/// Takes note of the warnings on their way to the user.
Callbacks notingWarnings(const Callbacks& callbacks, std::vector<std::string>& warnings) {
  Callbacks noting = callbacks;
  noting.log = [&callbacks, &warnings](LogLevel level, const std::string& text) {
    if (level == LogLevel::kWarning) warnings.push_back(text);
    if (callbacks.log) callbacks.log(level, text);
  };
  return noting;
}

}  // namespace

ColorizeSummary colorAndSave(const Recording& recording, const CommandLine& line, const Callbacks& user,
                             const std::vector<std::string>& image_names, Colorizer& colorizer) {
  RunFacts run;
  const Callbacks callbacks = notingWarnings(user, run.warnings);
  const std::string output = line.option("output");
  // What the format cannot hold is told before the work.
  {
    const CloudWriter trial(output, 0, coloredFields(recording, line.params), false, {},
                            coloredCrs(recording, line.params));
  }
  ColorizeSummary summary = colorizer(recording, line.params, callbacks);
  for (const StageCost& stage : summary.stages) {
    if (line.verbose) callbacks.log(LogLevel::kInfo, describe(stage));
  }
  callbacks.log(LogLevel::kInfo, summary.describe());
  warnOfDisagreement(summary, callbacks);
  saveColored(recording, line.params, output, callbacks);
  callbacks.log(LogLevel::kInfo, "saved " + output);
  if (line.has(kTilesOption.name)) {
    const std::string tiles = line.option(kTilesOption.name);
    saveColoredTiles(recording, line.params, tiles, lowerExtension(output), callbacks);
    callbacks.log(LogLevel::kInfo, "saved " + (std::filesystem::path(tiles) / "tiles.json").string());
  }
  if (line.has(kWriteModelOption.name)) {
    exportModel(recording, line.params, line.option(kWriteModelOption.name),
                {image_names, line.has(kUndistortOption.name)}, callbacks);
    exportPoints(recording, line.params, line.option(kWriteModelOption.name));
  }
  if (line.has(kSplatsOption.name)) {
    exportSplats(recording, line.params, line.option(kSplatsOption.name));
    callbacks.log(LogLevel::kInfo, "saved " + line.option(kSplatsOption.name));
  }
  if (line.has(kReportOption.name)) {
    run.summary = summary;
    run.name = std::filesystem::path(output).filename().string();
    saveReport(recording, line, line.option(kReportOption.name), run, callbacks);
  }
  return summary;
}

void saveReport(const Recording& recording, const CommandLine& line, const std::string& directory, RunFacts run,
                const Callbacks& callbacks) {
  run.program = versionText();
  for (const std::string& argument : line.arguments) {
    run.command.push_back(line.verbose ? argument : withoutFolders(argument));
  }
  const nlohmann::json report = writeReport(recording, line.params, run, directory, callbacks);
  callbacks.log(LogLevel::kInfo, "saved " + (std::filesystem::path(directory) / "report.html").string());
  if (!line.has(kFailIfOption.name)) return;
  const std::string condition = line.option(kFailIfOption.name);
  try {
    require<ConditionHolds>(!holds(condition, report), "--fail-if ", condition, " holds");
  } catch (const std::invalid_argument& error) {
    throw UsageError(std::string("--fail-if: ") + error.what());
  }
}

void requireColored(const ColorizeSummary& summary) {
  require<NothingColored>(summary.disagreement < kMostDisagreement,
                          "the map is saved, but its colours cannot be right: the views of a point differ from each "
                          "other nearly as much as the points do; the warning above tells where to look");
  if (summary.num_colored >= (summary.num_points + 99) / 100) return;
  const std::map<Unseen, const char*> remedies = {
      {Unseen::kOutside, "in no image; are poses, their convention and clock, and the calibration right?"},
      {Unseen::kTooFar, "beyond max_view_distance; raise it"},
      {Unseen::kHidden, "hidden; are the poses right, and does the map close surfaces that are open?"},
      {Unseen::kAbsent, "gone when images were taken; do clouds and images have the same clock? Else moving=off"},
      {Unseen::kMasked, "masked; black is where a camera must not colour"}};
  const auto count = [&](const auto& entry) { return summary.by_reason[static_cast<std::size_t>(entry.first)]; };
  const auto most = std::max_element(remedies.begin(), remedies.end(),
                                     [&](const auto& a, const auto& b) { return count(a) < count(b); });
  std::ostringstream text;
  text << "only " << summary.num_colored << " of " << summary.num_points
       << " points could be coloured: " << count(*most) << " are " << most->second;
  throw NothingColored(text.str());
}

}  // namespace cloud_colorizer
