// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause
#include "report/facts.hpp"

#include <algorithm>
#include <cmath>
#include <fstream>
#include <limits>
#include <map>
#include <set>
#include <utility>

#include "map/derived_files.hpp"
#include "report/consistency.hpp"
#include "visibility/moving.hpp"

namespace cloud_colorizer {
namespace {

using nlohmann::json;

/// What the alignment kept of itself; an empty object where it did not run.
json readAlignment(const std::string& path) {
  std::ifstream file(path);
  const json read = json::parse(file, nullptr, false);
  return read.is_object() ? read : json::object();
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
  if (alignment.value("poses_aligned", false))
    alignment["median_shift_of_width"] = shifts.empty() ? 0 : shifts[shifts.size() / 2];
  if (alignment.value("exposure_aligned", false)) alignment["gain_range"] = high / std::max(low, 1e-6);
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
                       {"model", toString(camera.intrinsics.model)},
                       {"kind", enumNames(camera.quantity.kind)[static_cast<std::size_t>(camera.quantity.kind)]}});
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

/// Typical distance from a point to the nearest camera, m.
double typicalDistance(const Recording& recording, const MapSample& sample) {
  constexpr std::size_t kMostPoints = 500, kMostViews = 2000;
  const std::size_t num_views = recording.views().size();
  const std::size_t step = std::max<std::size_t>(1, sample.size() / kMostPoints);
  const std::size_t view_step = std::max<std::size_t>(1, num_views / kMostViews);
  std::vector<float> distances;
  for (std::size_t i = 0; i < sample.size(); i += step) {
    if (sample.counts[i] == 0) continue;
    const Eigen::Vector3d point = Eigen::Map<const Eigen::Vector3f>(sample.positions.data() + 3 * i).cast<double>();
    double nearest = std::numeric_limits<double>::infinity();
    for (std::size_t v = 0; v < num_views; v += view_step) {
      nearest = std::min(nearest, (recording.views()[v].map_from_camera.translation() - point).norm());
    }
    distances.push_back(static_cast<float>(nearest));
  }
  return percentile(std::move(distances), 0.5);
}

constexpr double kShown = 0.95;  // of the numbers, below the bright end of a picture

double shownDeviation(const MapSample& sample) {
  std::vector<float> deviations;
  for (std::size_t i = 0; i < sample.size(); ++i) {
    if (sample.counts[i] >= 2) deviations.push_back(sample.deviations[i]);
  }
  return percentile(std::move(deviations), kShown);
}

/// m^2, as seen from above: cells that hold a point, as large as hold some 20 of the sample each.
double groundArea(const MapSample& sample) {
  constexpr double kPointsPerCell = 20;
  if (sample.size() == 0) return 0;
  Eigen::AlignedBox2f box;
  for (std::size_t i = 0; i < sample.size(); ++i) box.extend(Eigen::Vector2f(sample.positions.data() + 3 * i));
  const double side =
      std::sqrt(static_cast<double>(box.sizes().prod()) * kPointsPerCell / static_cast<double>(sample.size()));
  if (!(side > 0)) return 0;
  std::set<std::pair<std::int64_t, std::int64_t>> cells;
  for (std::size_t i = 0; i < sample.size(); ++i) {
    cells.emplace(static_cast<std::int64_t>(sample.positions[3 * i] / side),
                  static_cast<std::int64_t>(sample.positions[3 * i + 1] / side));
  }
  return side * side * static_cast<double>(cells.size());
}

/// What only points tell.
json measureMap(const Recording& recording, const MapSample& sample) {
  std::size_t colored = 0, seen_twice = 0, moved = 0;
  std::vector<float> thicknesses;
  for (std::size_t i = 0; i < sample.size(); ++i) {
    moved += sample.moving[i] >= kMovingShare;
    if (sample.counts[i] == 0) continue;
    ++colored;
    seen_twice += sample.counts[i] >= 2;
    thicknesses.push_back(sample.thicknesses[i]);
  }
  const auto share = [](std::size_t part, std::size_t whole) {
    return whole > 0 ? static_cast<double>(part) / static_cast<double>(whole) : 0.0;
  };
  const double shown_thickness = percentile(thicknesses, kShown);
  const double thickness = percentile(std::move(thicknesses), 0.5), distance = typicalDistance(recording, sample);
  double widest = 0;  // of the cameras, what a metre at a metre takes of an image's width
  for (const RecordedCamera& camera : recording.cameras()) {
    widest = std::max(widest, camera.intrinsics.fx / camera.intrinsics.width);
  }
  return {{"ground_area_m2", groundArea(sample)},
          {"seen_twice_share", share(seen_twice, colored)},
          {"moved_share", share(moved, sample.size())},
          {"thickness_m", thickness},
          {"shown_thickness_m", shown_thickness},
          {"shown_deviation", shownDeviation(sample)},
          {"view_distance_m", distance},
          {"seam", sample.seam ? json(*sample.seam) : json()},
          {"thickness_of_width", distance > 0 ? thickness / distance * widest : 0.0}};
}

}  // namespace

json collectFacts(const Recording& recording, const Params& params, const RunFacts& run, const MapSample& sample) {
  const ColorizeSummary& summary = run.summary;
  const auto reason = [&](Unseen unseen) { return summary.by_reason[static_cast<std::size_t>(unseen)]; };
  const auto share = [](std::size_t part, std::size_t whole) {
    return whole > 0 ? static_cast<double>(part) / static_cast<double>(whole) : 0.0;
  };
  const std::size_t in_reach = summary.num_points - reason(Unseen::kOutside) - reason(Unseen::kTooFar);
  json facts;
  facts["program"] = run.program;
  facts["name"] = run.name;
  facts["command"] = run.command;
  facts["map"] = {{"points", summary.num_points},
                  {"colored", summary.num_colored},
                  {"colored_share", share(summary.num_colored, summary.num_points)},
                  {"colored_share_in_reach", share(summary.num_colored, in_reach)},
                  {"views", recording.views().size()},
                  {"damaged_views", summary.num_damaged_views},
                  {"scans", recording.scans().size()},
                  {"duration_s", durationOf(recording)},
                  {"disagreement", summary.disagreement}};
  facts["map"].update(measureMap(recording, sample));
  facts["heldout"] = describeErrors(readErrors(recording));
  facts["uncolored"] = {{"in_no_image", reason(Unseen::kOutside)},
                        {"beyond_max_view_distance", reason(Unseen::kTooFar)},
                        {"hidden", reason(Unseen::kHidden)},
                        {"gone_when_images_were_taken", reason(Unseen::kAbsent)},
                        {"masked", reason(Unseen::kMasked)}};
  facts["cameras"] = camerasOf(recording);
  facts["parameters_changed"] = changedParams(params);
  facts["seconds"] = summary.seconds;
  facts["stages"] = json::array();
  for (const StageCost& stage : summary.stages) {
    facts["stages"].push_back({{"name", stage.name},
                               {"seconds", stage.seconds},
                               {"cpu_seconds", stage.cpu_seconds},
                               {"peak_mb", stage.peak_megabytes}});
  }
  facts["warnings"] = run.warnings;
  facts["alignment"] = {{"done", params.aligns()}};
  if (params.aligns()) {
    facts["alignment"] = readAlignment(recording.directory() + "/alignment/" + kAlignmentJson);
    facts["alignment"]["done"] = facts["alignment"].contains("views");
    if (facts["alignment"]["done"]) summarizeAlignment(facts["alignment"], recording);
    if (facts["alignment"].contains("warnings")) {
      for (const json& warning : facts["alignment"]["warnings"]) facts["warnings"].push_back(warning);
    }
  }
  auto& warnings = facts["warnings"];
  std::vector<std::string> once;  // the alignment's are in the run's as well
  for (const json& warning : warnings) {
    if (std::find(once.begin(), once.end(), warning.get<std::string>()) == once.end()) once.push_back(warning);
  }
  warnings = once;
  return facts;
}

}  // namespace cloud_colorizer
