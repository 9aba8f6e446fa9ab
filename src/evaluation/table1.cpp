// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause

/// Table 1 and figure 4 of the paper: error by method, mesh and kind of noise.
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <map>
#include <set>

#include "base/progress.hpp"
#include "base/text.hpp"
#include "cloud_colorizer/base/check.hpp"
#include "cloud_colorizer/picture/picture.hpp"
#include "evaluation/tables.hpp"

namespace cloud_colorizer {
namespace {

struct NoiseKind {
  std::string name;
  NoiseParams params;
};

std::vector<NoiseKind> noiseKinds(const NoiseParams& noise) {
  return {{"both", noise}, {"extrinsics", noise.onlyExtrinsics()}, {"intensities", noise.onlyIntensities()}};
}

/// The rows of one bed. Where every part of a graph has an anchor (or its row was stopped), the plain row is the same
/// as the anchored one and is not computed again.
class Rows {
 public:
  /// `stopped`: graphs that ran into a limit on this mesh already, with the reason. They hardly depend on the noise.
  Rows(const TestBed& bed, const ObservedBed& observed, const TablesParams& params,
       std::map<std::string, std::string>& stopped)
      : bed_(bed), observed_(observed), params_(params), stopped_(stopped) {}

  const MethodRun& of(const std::string& method) {
    const auto known = rows_.find(method);
    if (known != rows_.end()) return known->second;
    static const std::string kPlain = " plain";
    if (endsWith(method, kPlain)) {
      const MethodRun& anchored = of(method.substr(0, method.size() - kPlain.size()));
      if (anchored.status != "ok" || anchored.result.unanchored_share == 0) return anchored;
    }
    MethodRun& row = rows_[method];
    const auto stopped = stopped_.find(method);
    if (stopped != stopped_.end()) {
      row.status = stopped->second;
      row.result.seconds = std::nan("");
      return row;
    }
    row = runMethod(bed_, observed_, method, params_.method, params_.limits);
    if (row.status != "ok") stopped_[method] = row.status + " already";
    return row;
  }

 private:
  const TestBed& bed_;
  const ObservedBed& observed_;
  const TablesParams& params_;
  std::map<std::string, std::string>& stopped_;
  std::map<std::string, MethodRun> rows_;
};

const std::vector<std::string> kHeader = {"mesh",
                                          "noise",
                                          "method",
                                          "status",
                                          "aep",
                                          "rep",
                                          "psnr",
                                          "ciede2000",
                                          "coverage",
                                          "aep_gain",
                                          "rep_gain",
                                          "seconds",
                                          "neighbours",
                                          "unanchored_percent",
                                          "reprojection_px",
                                          "gain_error_percent"};

std::vector<std::string> cells(const std::string& mesh, const std::string& noise, const std::string& method,
                               const MethodRun& row, const TestBed& bed) {
  const MethodResult& r = row.result;
  std::vector<std::string> line = {mesh, noise, method, row.status};
  if (row.status != "ok") {
    line.resize(kHeader.size(), "-");
    line[11] = formatNumber(r.seconds, 2);
    return line;
  }
  const Score s = scoreColors(bed.truth, r.values, r.colored);
  for (const auto& [value, digits] : {std::pair(s.aep, 3),
                                      {s.rep, 4},
                                      {s.psnr, 2},
                                      {s.ciede2000, 3},
                                      {s.coverage, 4},
                                      {s.aep_gain, 3},
                                      {s.rep_gain, 4},
                                      {r.seconds, 2},
                                      {r.edges_per_point, 2},
                                      {100 * r.unanchored_share, 3},
                                      {r.reprojection_error, 3},
                                      {100 * r.gain_error, 2}}) {
    line.push_back(formatNumber(value, digits));
  }
  return line;
}

cv::Mat drawCloseup(const TestBed& bed, const Values& values) {
  PictureParams params;
  params.width = 360;
  params.height = 360;
  params.field_of_view = 24;
  const double area = 4 * 3.14 / static_cast<double>(bed.points.cols());  // of a sphere of diameter 2, by point
  params.point_size = 2 * std::sqrt(area);
  const auto points = [&](const std::function<void(PointsRef, ValuesRef)>& visit) { visit(bed.points, values); };
  return drawPicture(points, lookAt({1.9, 1.5, 1.2}, {0.1, 0.1, 0.1}), params);
}

/// The paper's figure 4: the truth and some methods, in rows of five.
class Closeups {
 public:
  void add(const std::string& caption, const TestBed& bed, const Values& values) {
    pictures_.push_back(drawCloseup(bed, values));
    captions_.push_back(caption);
  }

  cv::Mat arrange() {
    constexpr std::size_t kAcross = 5;
    std::vector<cv::Mat> rows;
    while (pictures_.size() % kAcross != 0) {
      pictures_.emplace_back(pictures_[0].size(), pictures_[0].type(), cv::Scalar(255, 255, 255));
      captions_.emplace_back("");
    }
    for (std::size_t at = 0; at < pictures_.size(); at += kAcross) {
      const auto begin = static_cast<std::ptrdiff_t>(at), end = static_cast<std::ptrdiff_t>(at + kAcross);
      rows.push_back(besideEachOther({pictures_.begin() + begin, pictures_.begin() + end},
                                     {captions_.begin() + begin, captions_.begin() + end}));
    }
    cv::Mat all;
    cv::vconcat(rows, all);
    return all;
  }

 private:
  std::vector<cv::Mat> pictures_;
  std::vector<std::string> captions_;
};

}  // namespace

TablesParams TablesParams::quick() {
  TablesParams params;
  params.bed.num_points = 65000;
  params.limits.seconds = 20;
  params.density_sizes = {};
  params.table2_sizes = {65000, 200000};
  return params;
}

std::vector<Mesh> loadMeshes(const std::string& directory) {
  if (directory.empty()) return {bumpySphere(), knottedTorus()};
  require(std::filesystem::is_directory(directory), directory, ": no such directory of meshes");
  std::vector<std::string> paths;
  for (const auto& entry : std::filesystem::directory_iterator(directory)) {
    if (entry.path().extension() == ".ply") paths.push_back(entry.path().string());
  }
  require(!paths.empty(), directory, ": no mesh (*.ply) in it");
  std::sort(paths.begin(), paths.end());
  std::vector<Mesh> meshes;
  meshes.reserve(paths.size());
  for (const std::string& path : paths) meshes.push_back(readMesh(path));
  return meshes;
}

Table1 makeTable1(const std::vector<Mesh>& meshes, const TablesParams& params, const Callbacks& callbacks) {
  static const std::set<std::string> kShown = {"closest", "mean",   "median", "5-NN",   "20-NN",
                                               "DT",      "1-pass", "4-pass", "default"};
  Table1 result;
  result.table.header = kHeader;
  Closeups closeups;
  ProgressMeter meter(callbacks, "table 1", meshes.size() * noiseKinds(params.noise).size() * methodNames().size());
  for (const Mesh& mesh : meshes) {
    const TestBed clean = renderTestBed(mesh, params.bed);
    std::map<std::string, std::string> stopped;
    for (const NoiseKind& kind : noiseKinds(params.noise)) {
      const TestBed bed = addNoise(clean, kind.params, params.bed.seed, params.bed.num_threads);
      const ObservedBed observed = observeBed(bed, bed.poses, {}, params.method);
      Rows rows(bed, observed, params, stopped);
      const bool shown = &mesh == &meshes.front() && kind.name == "both";
      if (shown) closeups.add("truth", bed, bed.truth);
      for (const std::string& method : methodNames()) {
        const MethodRun& row = rows.of(method);
        result.table.add(cells(mesh.name, kind.name, method, row, bed));
        if (shown && row.status == "ok" && kShown.count(method) != 0) closeups.add(method, bed, row.result.values);
        meter.add(1, false);
      }
    }
  }
  result.closeup = closeups.arrange();
  return result;
}

}  // namespace cloud_colorizer
