// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause
#include "report/facts.hpp"

#include <algorithm>
#include <fstream>
#include <map>
#include <sstream>

#include "base/text.hpp"

namespace cloud_colorizer {
namespace {

using nlohmann::json;

/// alignment/views.csv as {"columns": [...], "rows": [[...], ...]} without the reasons, whose commas are no borders.
json readAlignmentViews(const std::string& path) {
  json rows = json::array();
  std::ifstream file(path);
  std::string line;
  std::getline(file, line);
  while (std::getline(file, line)) {
    const auto words = splitAt(line.substr(0, line.find('"')), ',');
    json row = json::array();
    for (std::size_t i = 0; i + 1 < words.size(); ++i) {
      double value = 0;
      if (parseDouble(words[i], value)) row.push_back(value);
    }
    if (row.size() == 14) rows.push_back(std::move(row));
  }
  return {{"columns",
           {"view", "camera", "stamp", "points", "rotation_deg", "translation_m", "pixels", "gain_r", "gain_g",
            "gain_b", "weight", "residual_before", "residual_after", "refused"}},
          {"rows", rows}};
}

/// Lines of alignment/report.txt: its warnings, and what it says of the cameras.
void readAlignmentText(const std::string& path, json& facts) {
  std::ifstream file(path);
  json text = json::array();
  for (std::string line; std::getline(file, line);) {
    const std::string warning = "Warning: ";
    if (line.rfind(warning, 0) == 0) {
      facts["warnings"].push_back(line.substr(warning.size()));
    } else if (!line.empty()) {
      text.push_back(line);
    }
  }
  facts["alignment"]["text"] = text;
}

/// Of columns of the table of views, weighted by their points; none where no view has any.
void summarizeAlignment(json& alignment, const Recording& recording) {
  double points = 0, before = 0, after = 0, low = 1, high = 1;
  std::vector<double> shifts;
  for (const json& row : alignment["views"]["rows"]) {
    const double weight = row[3];
    points += weight;
    before += weight * row[11].get<double>();
    after += weight * row[12].get<double>();
    for (int channel = 7; channel < 10; ++channel) {
      low = std::min(low, row[channel].get<double>());
      high = std::max(high, row[channel].get<double>());
    }
    const auto view = static_cast<std::size_t>(row[0].get<double>());
    if (view >= recording.views().size()) continue;
    const double width = recording.cameras()[recording.views()[view].camera].intrinsics.width;
    shifts.push_back(row[6].get<double>() / width);
  }
  if (points <= 0) return;
  std::sort(shifts.begin(), shifts.end());
  alignment["heldout_error_before"] = before / points;
  alignment["heldout_error"] = after / points;
  alignment["median_shift_of_width"] = shifts.empty() ? 0 : shifts[shifts.size() / 2];
  alignment["gain_range"] = high / std::max(low, 1e-6);
}

json changedParams(const Params& params) {
  json changed = json::object();
  std::map<std::string, std::string> defaults;
  for (const ParamText& param : describeParams(Params())) defaults[param.name] = param.value;
  for (const ParamText& param : describeParams(params)) {
    if (defaults[param.name] != param.value) changed[param.name] = param.value;
  }
  return changed;
}

json camerasOf(const Recording& recording) {
  std::vector<std::size_t> views(recording.cameras().size());
  for (const View& view : recording.views()) ++views[view.camera];
  json cameras = json::array();
  for (std::size_t i = 0; i < views.size(); ++i) {
    const RecordedCamera& camera = recording.cameras()[i];
    cameras.push_back({{"name", camera.name},
                       {"views", views[i]},
                       {"width", camera.intrinsics.width},
                       {"height", camera.intrinsics.height},
                       {"model", toString(camera.intrinsics.model)}});
  }
  return cameras;
}

double durationOf(const Recording& recording) {
  double first = 0, last = 0;
  for (const View& view : recording.views()) {
    if (&view == &recording.views().front()) first = last = view.stamp;
    first = std::min(first, view.stamp);
    last = std::max(last, view.stamp);
  }
  return last - first;
}

json light(const char* name, const char* state, const json& value, const char* thresholds, const char* meaning,
           const char* remedy) {
  return {{"name", name},       {"state", state},  {"value", value}, {"thresholds", thresholds},
          {"meaning", meaning}, {"remedy", remedy}};
}

/// The larger the worse, or where `green` is above `red`, the smaller.
const char* stateOf(double value, double green, double red) {
  const bool rises = green < red;
  if (rises ? value < green : value > green) return "green";
  return (rises ? value < red : value > red) ? "yellow" : "red";
}

bool anyWarning(const json& facts, std::initializer_list<const char*> words) {
  for (const json& warning : facts["warnings"]) {
    const std::string text = lowerCase(warning.get<std::string>());
    for (const char* word : words) {
      if (text.find(word) != std::string::npos) return true;
    }
  }
  return false;
}

}  // namespace

json collectFacts(const Recording& recording, const Params& params, const RunFacts& run) {
  const ColorizeSummary& summary = run.summary;
  const auto reason = [&](Unseen unseen) { return summary.by_reason[static_cast<std::size_t>(unseen)]; };
  const auto share = [](std::size_t part, std::size_t whole) {
    return whole > 0 ? static_cast<double>(part) / static_cast<double>(whole) : 0.0;
  };
  const std::size_t in_reach = summary.num_points - reason(Unseen::kOutside) - reason(Unseen::kTooFar);
  json facts;
  facts["program"] = run.program;
  facts["name"] = run.name;
  facts["map"] = {{"points", summary.num_points},
                  {"colored", summary.num_colored},
                  {"colored_share", share(summary.num_colored, summary.num_points)},
                  {"colored_share_in_reach", share(summary.num_colored, in_reach)},
                  {"views", recording.views().size()},
                  {"damaged_views", summary.num_damaged_views},
                  {"scans", recording.scans().size()},
                  {"duration_s", durationOf(recording)},
                  {"disagreement", summary.disagreement}};
  facts["uncolored"] = {{"in_no_image", reason(Unseen::kOutside)},
                        {"beyond_max_view_distance", reason(Unseen::kTooFar)},
                        {"hidden", reason(Unseen::kHidden)},
                        {"gone_when_images_were_taken", reason(Unseen::kAbsent)},
                        {"masked", reason(Unseen::kMasked)}};
  facts["cameras"] = camerasOf(recording);
  facts["parameters_changed"] = changedParams(params);
  facts["seconds"] = summary.seconds;
  facts["warnings"] = run.warnings;
  facts["alignment"] = {{"done", params.aligns()}};
  if (params.aligns()) {
    readAlignmentText(recording.directory() + "/alignment/report.txt", facts);
    facts["alignment"]["views"] = readAlignmentViews(recording.directory() + "/alignment/views.csv");
    summarizeAlignment(facts["alignment"], recording);
  }
  auto& warnings = facts["warnings"];
  std::vector<std::string> once;  // the alignment's are in the run's as well
  for (const json& warning : warnings) {
    if (std::find(once.begin(), once.end(), warning.get<std::string>()) == once.end()) once.push_back(warning);
  }
  warnings = once;
  return facts;
}

json lightsOf(const json& facts) {
  json lights = json::array();
  const json &map = facts["map"], &alignment = facts["alignment"];
  lights.push_back(light("Coloured", stateOf(map["colored_share_in_reach"], 0.6, 0.3), map["colored_share_in_reach"],
                         "green above 60 %, red below 30 %",
                         "share of the points in an image, within max_view_distance, that got a colour; the others are "
                         "hidden, often truly",
                         "Look at the reasons below. Poses that are off, or a thick map, hide too much."));
  const double disagreement = map["disagreement"];
  lights.push_back(light("Agreement of the views", disagreement > 0 ? stateOf(disagreement, 0.5, 0.7) : "grey",
                         disagreement, "green below 0.5, red above 0.7",
                         "how much the views of a point differ, against how much the points do",
                         "Poses, calibration or clocks cannot be right: look at their conventions and units."));
  const bool is_known = alignment.contains("heldout_error");
  lights.push_back(light("Held-out colour error", is_known ? stateOf(alignment["heldout_error"], 15, 30) : "grey",
                         is_known ? alignment["heldout_error"] : json(), "green below 15, red above 30 (of 255)",
                         "each view predicted from the others, at points that took no part in the alignment",
                         "Better poses, or a better calibration; glass and what moves have their share."));
  const bool is_suspect = anyWarning(facts, {"calibration", "clock", "time offset"});
  std::string poses = is_known ? stateOf(alignment["median_shift_of_width"], 0.002, 0.004) : "grey";
  if (poses == "red" && is_suspect) poses = "yellow";  // it is not the poses
  lights.push_back(light("Poses", poses.c_str(), is_known ? alignment["median_shift_of_width"] : json(),
                         "green below 0.2 %, red above 0.4 % of the image's width",
                         "by how much the alignment had to move the images (median)",
                         "The poses or the calibration are off by so much before it: mend them where you can."));
  lights.push_back(light("Calibration and clocks",
                         is_suspect          ? "red"
                         : alignment["done"] ? "green"
                                             : "grey",
                         is_suspect ? "see the warnings" : "nothing found", "red where a warning names them",
                         "whether one correction of a camera, or of its clock, explains what held-back points show",
                         "Calibrate that camera again, or set camera_<i>/time_offset as the warning says."));
  lights.push_back(light("Exposure", is_known ? stateOf(alignment["gain_range"], 4, 10) : "grey",
                         is_known ? alignment["gain_range"] : json(), "green below 4, red above 10",
                         "largest gain of a view over the smallest, which are evened out",
                         "Fix exposure and white balance, or let them change slowly."));
  lights.push_back(light("Images", map["damaged_views"] > 0 ? "red" : "green", map["damaged_views"], "red above 0",
                         "images that could not be decoded, and were left out",
                         "The log names them: look at the disk and the driver."));
  return lights;
}

}  // namespace cloud_colorizer
