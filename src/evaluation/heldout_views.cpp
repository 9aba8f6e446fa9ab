// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <filesystem>
#include <fstream>
#include <map>

#include "cloud_colorizer/base/check.hpp"
#include "evaluation/heldout.hpp"

namespace cloud_colorizer {
namespace {

namespace fs = std::filesystem;

void link(const std::string& from, const std::string& to, const std::string& name) {
  if (name.empty() || !fs::exists(from + "/" + name)) return;
  fs::remove(to + "/" + name);
  fs::create_symlink(fs::absolute(from + "/" + name), to + "/" + name);
}

}  // namespace

void HeldoutParams::check() const {
  requireInRange("every", every, 2, 1000000);
  requireInRange("moved_error", moved_error, 1.0, 255.0);
  params.check();
}

std::vector<std::size_t> heldoutViews(const std::vector<View>& views, int every) {
  requireInRange("every", every, 2, 1000000);
  std::map<std::uint32_t, int> seen;
  std::vector<std::size_t> chosen;
  for (std::size_t v = 0; v < views.size(); ++v) {
    if (seen[views[v].camera]++ % every == every / 2) chosen.push_back(v);
  }
  return chosen;
}

Recording withViews(const Recording& recording, const std::vector<std::size_t>& views, const std::string& directory) {
  const std::string& from = recording.directory();
  makeDirectory(directory);
  for (const char* name : {"recording.yaml", "cameras.yaml", "images", "tiles", "scans.csv", "scans"})
    link(from, directory, name);
  for (const RecordedCamera& camera : recording.cameras()) {
    link(from, directory, camera.mask.substr(0, camera.mask.find('/')));
  }
  std::ifstream in(from + "/views.csv");
  std::string line, text;
  require(static_cast<bool>(std::getline(in, line)), from, "/views.csv: cannot read it");
  text = line + "\n";
  std::vector<std::string> lines;
  while (std::getline(in, line)) lines.push_back(line);
  for (const std::size_t view : views) {
    require(view < lines.size(), from, "/views.csv: view ", view, " is missing");
    text += lines[view] + "\n";
  }
  writeText(directory + "/views.csv", text);
  return Recording::open(directory);
}

}  // namespace cloud_colorizer
