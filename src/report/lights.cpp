// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause
#include <cstdio>
#include <string>

#include "base/text.hpp"
#include "report/facts.hpp"

namespace cloud_colorizer {
namespace {

using nlohmann::json;

/// What a light says of itself, whatever its state.
struct LightText {
  const char *name, *thresholds, *meaning, *remedy;
};

json light(const LightText& text, const std::string& state, const json& value) {
  return {{"name", text.name},       {"state", state},       {"value", value}, {"thresholds", text.thresholds},
          {"meaning", text.meaning}, {"remedy", text.remedy}};
}

/// The larger the worse, or where `green` is above `red`, the smaller.
const char* stateOf(double value, double green, double red) {
  const bool rises = green < red;
  if (rises ? value < green : value > green) return "green";
  return (rises ? value < red : value > red) ? "yellow" : "red";
}

/// Grey where there is no such number.
json numberLight(const LightText& text, const json& facts, const char* name, double green, double red) {
  if (!facts.contains(name) || !facts[name].is_number()) return light(text, "grey", nullptr);
  return light(text, stateOf(facts[name], green, red), facts[name]);
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

json agreementLight(const json& map) {
  const double disagreement = map["disagreement"];
  return light({"Agreement of the views", "green below 0.5, red above 0.7",
                "how much the views of a point differ, against how much the points do",
                "Poses, calibration or clocks cannot be right: look at their conventions and units."},
               disagreement > 0 ? stateOf(disagreement, 0.5, 0.7) : "grey", disagreement);
}

json calibrationLight(const json& facts, bool is_suspect) {
  const json& alignment = facts["alignment"];
  return light({"Calibration and clocks", "red where one correction of a camera, or of its clock, explains its images",
                "whether one correction of a camera, or of its clock, explains what held-back points show",
                "Calibrate that camera again, or set camera_<i>/time_offset as the warning says."},
               is_suspect                                ? "red"
               : alignment.value("poses_aligned", false) ? "green"
                                                         : "grey",
               is_suspect ? "see the warnings" : "nothing found");
}

json overlapLight(const json& facts) {
  json overlap = numberLight({"Overlap", "green above 60 %, red below 30 %, or where nothing could be aligned for it",
                              "share of the coloured points that two views see: only these can prove anything",
                              "More keyframes (a smaller keyframe_distance), or cameras that look at the same places."},
                             facts["map"], "seen_twice_share", 0.6, 0.3);
  if (anyWarning(facts, {"nothing was aligned: only"})) overlap["state"] = "red";
  return overlap;
}

json posesLight(const json& facts, bool is_suspect) {
  const LightText text = {"Poses",
                          "green below 0.2 %, red above 0.4 % of the image's width, or where a warning names them",
                          "by how much the alignment had to move the images (median)",
                          "The poses or the calibration are off by so much before it: mend them where you can."};
  json poses = numberLight(text, facts["alignment"], "median_shift_of_width", 0.002, 0.004);
  if (anyWarning(facts, {"the poses or the map differ"})) poses["state"] = "red";
  if (poses["state"] == "red" && is_suspect) poses["state"] = "yellow";  // it is not the poses
  return poses;
}

json masksLight(const json& facts) {
  const json& part = facts["heldout"]["worst_part"];
  const double ratio = part["error_ratio"];
  std::string value = "nothing found";
  if (ratio > 0) {
    char text[160];
    std::snprintf(text, sizeof text, "camera_%d: from %.0f to %.0f %% of the width, %.0f to %.0f %% of the height",
                  part["camera"].get<int>(), 100 * part["left"].get<double>(), 100 * part["right"].get<double>(),
                  100 * part["top"].get<double>(), 100 * part["bottom"].get<double>());
    value = text;
  }
  return light({"Masks", "red where a part of the images is off by 2.5 times the rest",
                "whether the same part of all images of a camera contradicts the other views",
                "The vehicle, dirt or a time stamp is in the images there: give camera_<i>/mask, black where it is."},
               ratio > 0                        ? "red"
               : facts["heldout"]["points"] > 0 ? "green"
                                                : "grey",
               value);
}

}  // namespace

json lightsOf(const json& facts) {
  const json &map = facts["map"], &alignment = facts["alignment"], &held_out = facts["heldout"];
  const bool is_suspect = anyWarning(facts, {"calibration", "clock", "time offset"});
  json lights = json::array();
  lights.push_back(numberLight({"Coloured", "green above 60 %, red below 30 %",
                                "share of the points in an image, within max_view_distance, that got a colour; the "
                                "others are hidden, often truly",
                                "Look at the reasons below. Poses that are off, or a thick map, hide too much."},
                               map, "colored_share_in_reach", 0.6, 0.3));
  lights.push_back(
      numberLight({"Certainly seen", "green above 88 %, red below 70 %",
                   "share of the points that got a colour, of those in an image that a scan of the moment "
                   "measured: nothing stood before them",
                   "A thick map or wrong poses hide what is in sight; masks and max_view_distance as well."},
                  map, "certainly_seen_colored_share", 0.88, 0.7));
  lights.push_back(overlapLight(facts));
  lights.push_back(numberLight({"Held-out colour error", "green below 15, red above 30 (of 255)",
                                "a view of a point, left out, against what the others predict (mean)",
                                "Better poses, or a better calibration; glass and what moves have their share."},
                               held_out["points"] > 0 ? held_out : json::object(), "error", 15, 30));
  lights.push_back(agreementLight(map));
  lights.push_back(posesLight(facts, is_suspect));
  lights.push_back(calibrationLight(facts, is_suspect));
  lights.push_back(numberLight(
      {"Exposure", "green below 4, red above 10", "largest gain of a view over the smallest, which are evened out",
       "Fix exposure and white balance, or let them change slowly."},
      alignment, "gain_range", 4, 10));
  lights.push_back(numberLight({"Thickness of the map", "green below 0.5 %, red above 1.5 % of the image's width",
                                "the slab that the points of a surface make, as a camera at the usual distance sees it",
                                "Better poses of the scans; a map that is thick cannot have sharper colours."},
                               map, "thickness_of_width", 0.005, 0.015));
  lights.push_back(
      numberLight({"Seams", "green below 0.5, red above 2 (of 255)",
                   "by how much more neighbours differ where one chunk ends and another begins than right beside it",
                   "A larger overlap, or larger chunks (max_chunk_points)."},
                  map, "seam", 0.5, 2));
  lights.push_back(numberLight(
      {"What moved", "green below 5 %, red above 20 %", "share of the points that later or earlier scans saw through",
       "moving=drop takes them out of the map. Very many: poses or scan_resolution are off."},
      map["scans"] > 0 ? map : json::object(), "moved_share", 0.05, 0.2));
  lights.push_back(masksLight(facts));
  lights.push_back(light({"Images", "red above 0", "images that could not be decoded, and were left out",
                          "The log names them: look at the disk and the driver."},
                         map["damaged_views"] > 0 ? "red" : "green", map["damaged_views"]));
  return lights;
}

}  // namespace cloud_colorizer
