// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause
#include "cloud_colorizer/map/params.hpp"

#include <stdexcept>

#include "base/param_text.hpp"

namespace cloud_colorizer {
std::vector<std::string> enumNames(Method) {
  return {"default", "paper", "mean", "median", "closest"};
}
std::vector<std::string> enumNames(Uncolored) {
  return {"keep", "drop", "fill"};
}
std::vector<std::string> enumNames(SolverKind) {
  return {"cg", "cholmod", "spqr"};
}
std::vector<std::string> enumNames(PassGrids) {
  return {"own", "shared"};
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
  requireInRange("memory_limit", memory_limit, 100.0, 1e7);
}

void Params::check() const {
  record.check();
  surfels.check();
  depth.check();
  alignment.check();
  observe.check();
  graph.check();
  system.check();
  tone.check();
  chunks.check();
  colorize.check();
}

void setParam(Params& params, const std::string& name, const std::string& text) {
  const auto visit = [&](const auto& f) { visitParams(params, f); };
  if (setField(visit, "parameter ", name, text)) return;
  std::vector<std::string> known;
  for (const ParamText& param : describeParams(params)) known.push_back(param.name);
  throw std::invalid_argument("unknown parameter '" + name + "'; did you mean '" + nearestName(name, known) + "'?");
}

std::vector<ParamText> describeParams(const Params& params) {
  return describeFields([&](const auto& f) { visitParams(params, f); });
}

}  // namespace cloud_colorizer
