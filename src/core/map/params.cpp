// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause
#include "cloud_colorizer/map/params.hpp"

#include <map>
#include <stdexcept>

#include "base/param_text.hpp"
#include "cloud/crs.hpp"

namespace cloud_colorizer {
std::vector<std::string> enumNames(Method) {
  return {"default", "paper", "mean", "median", "closest"};
}
std::vector<std::string> enumNames(Moving) {
  return {"keep", "mark", "drop"};
}

std::vector<std::string> enumNames(Tone) {
  return {"display", "radiance"};
}

std::vector<std::string> enumNames(Uncolored) {
  return {"keep", "drop", "fill"};
}
std::vector<std::string> enumNames(Appearance) {
  return {"none", "sh1", "sh2"};
}
std::vector<std::string> enumNames(SolverKind) {
  return {"cg", "cholmod", "spqr"};
}
std::vector<std::string> enumNames(PassGrids) {
  return {"auto", "own", "shared"};
}
std::vector<std::string> enumNames(AnchorKind) {
  return {"random", "consistent"};
}
std::vector<std::string> enumNames(AlignPoses) {
  return {"none", "cameras", "views"};
}

void ColorizeParams::check() const {
  requireInRange("fill_distance", fill_distance, 0.0, 1e3);
  requireInRange("num_threads", num_threads, 0, 1024);
  try {
    if (!crs.empty()) wellKnownText(crs);
  } catch (const std::invalid_argument& error) {
    throw std::invalid_argument(std::string("parameter crs: ") + error.what());
  }
  if (memory_limit != 0) requireInRange("memory_limit", memory_limit, 100.0, 1e7);
}

void Params::check() const {
  record.check();
  surfels.check();
  depth.check();
  alignment.check();
  observe.check();
  graph.check();
  system.check();
  chunks.check();
  colorize.check();
}

std::string removedParam(const std::string& name) {
  static const std::map<std::string, const char*> kInstead = {
      {"alignment_blur", "the first blur follows pose_rotation_prior and extrinsic_rotation_prior"},
      {"alignment_rounds", "there are 4 rounds at each blur"},
      {"edge_length_ratio", "all edges count alike"},
      {"exposure_range", "tone=display is as bright as the images everywhere, tone=radiance nowhere follows them"},
      {"extrinsic_translation_prior", "the place is expected to be off by as many pixels as extrinsic_rotation_prior"},
      {"image_border", "3 px at the border of an image are not used"},
      {"max_gain", "gains stay within 1/5 and 5"},
      {"max_open_tiles", "the voxels of 1024 tiles are held in memory"},
      {"max_preview_points", "the preview has 500000 points at most"},
      {"no_evidence_weight", "edges that no view sees whole have weight 0.01"},
      {"num_neighbors", "16 points give a surfel"},
      {"pose_translation_prior", "the place is expected to be off by as many pixels as pose_rotation_prior"},
      {"preview_voxel_size", "the preview has one point in 0.25 m"},
      {"tf_cache", "transforms are kept for 30 s, or twice tf_wait"},
      {"use_scans", "scan_resolution=0 is to record and to use no scans"}};
  const auto found = kInstead.find(name);
  return found == kInstead.end() ? "" : "parameter " + name + " is gone: " + found->second;
}

bool Params::aligns() const {
  return colorize.method == Method::kDefault &&
         (alignment.align_exposure || alignment.align_poses != AlignPoses::kNone);
}

void setParam(Params& params, const std::string& name, const std::string& text) {
  const auto visit = [&](const auto& f) { visitParams(params, f); };
  if (setField(visit, "parameter ", name, text)) return;
  const std::string removed = removedParam(name);
  require<std::invalid_argument>(removed.empty(), removed);
  std::vector<std::string> known;
  for (const ParamText& param : describeParams(params)) known.push_back(param.name);
  throw std::invalid_argument("unknown parameter '" + name + "'; did you mean '" + nearestName(name, known) + "'?");
}

std::vector<ParamText> describeParams(const Params& params) {
  return describeFields([&](const auto& f) { visitParams(params, f); });
}

}  // namespace cloud_colorizer
