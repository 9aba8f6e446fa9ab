// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause

/// Table 1 and figure 4 of the paper: error by method, mesh and kind of noise.
#include <algorithm>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <map>
#include <set>

#include "cloud_colorizer/base/check.hpp"
#include "cloud_colorizer/picture/picture.hpp"
#include "evaluation/neighbors.hpp"
#include "evaluation/tables.hpp"

namespace cloud_colorizer {
namespace {

struct NoiseKind {
  std::string name;
  NoiseParams params;
};

std::vector<NoiseKind> noiseKinds(const NoiseParams& noise) {
  return {{"both", noise},
          {"extrinsics", {noise.rotation, noise.centre, 0, 0}},
          {"intensities", {0, 0, noise.gain, noise.pixel}}};
}

bool isGraph(const std::string& method) {
  return method.find("-NN") != std::string::npos || method.find("-pass") != std::string::npos ||
         method.rfind("DT", 0) == 0;
}

template <class T>
void append(std::string& bytes, const T* values, std::size_t count) {
  bytes.append(reinterpret_cast<const char*>(values), count * sizeof(T));
}

template <class T>
void take(const std::string& bytes, std::size_t& at, T* values, std::size_t count) {
  require(at + count * sizeof(T) <= bytes.size(), "a result from a child process is cut off");
  std::memcpy(values, bytes.data() + at, count * sizeof(T));
  at += count * sizeof(T);
}

std::string pack(const MethodResult& result) {
  std::string bytes;
  append(bytes, result.values.data(), static_cast<std::size_t>(result.values.size()));
  append(bytes, result.colored.data(), result.colored.size());
  const double numbers[] = {result.seconds, result.edges_per_point, result.unanchored_share, result.reprojection_error,
                            result.gain_error};
  append(bytes, numbers, 5);
  return bytes;
}

MethodResult unpack(const std::string& bytes, Eigen::Index num_points) {
  MethodResult result;
  result.values.resize(3, num_points);
  result.colored.resize(static_cast<std::size_t>(num_points));
  double numbers[5];
  std::size_t at = 0;
  take(bytes, at, result.values.data(), static_cast<std::size_t>(result.values.size()));
  take(bytes, at, result.colored.data(), result.colored.size());
  take(bytes, at, numbers, 5);
  result.seconds = numbers[0];
  result.edges_per_point = numbers[1];
  result.unanchored_share = numbers[2];
  result.reprojection_error = numbers[3];
  result.gain_error = numbers[4];
  return result;
}

struct Row {
  std::string status = "ok";
  MethodResult result;
};

/// Graphs may take for ever, so they run in a process with limits; the alignment of `default` needs threads.
Row runMethod(const TestBed& bed, const ObservedBed& observed, const std::string& method, const TablesParams& params) {
  Row row;
  const bool needs_nearest = method.find("-NN") != std::string::npos, needs_delaunay = method.rfind("DT", 0) == 0;
  if ((needs_nearest && !hasNearestNeighbors()) || (needs_delaunay && !hasDelaunay())) {
    row.status = "not built";
  } else if (isGraph(method)) {
    const LimitedRun run =
        runLimited([&] { return pack(colorizeArrays(bed, observed, method, params.method)); }, params.limits);
    row.status = run.status;
    row.result.seconds = run.seconds;
    if (run.status == "ok") row.result = unpack(run.bytes, bed.points.cols());
  } else {
    row.result = colorizeArrays(bed, observed, method, params.method);
  }
  return row;
}

/// The rows of one bed. Where every part of a graph has an anchor (or its row was stopped), the plain row is the same
/// as the anchored one and is not computed again.
class Rows {
 public:
  /// `stopped`: graphs that ran into a limit on this mesh already, with the reason. They hardly depend on the noise.
  Rows(const TestBed& bed, const ObservedBed& observed, const TablesParams& params,
       std::map<std::string, std::string>& stopped)
      : bed_(bed), observed_(observed), params_(params), stopped_(stopped) {}

  const Row& of(const std::string& method) {
    const auto known = rows_.find(method);
    if (known != rows_.end()) return known->second;
    static const std::string kPlain = " plain";
    if (method.size() > kPlain.size() && method.substr(method.size() - kPlain.size()) == kPlain) {
      const Row& anchored = of(method.substr(0, method.size() - kPlain.size()));
      if (anchored.status != "ok" || anchored.result.unanchored_share == 0) return anchored;
    }
    Row& row = rows_[method];
    const auto stopped = stopped_.find(method);
    if (stopped != stopped_.end()) {
      row.status = stopped->second;
      row.result.seconds = std::nan("");
      return row;
    }
    row = runMethod(bed_, observed_, method, params_);
    if (row.status != "ok") stopped_[method] = row.status + " already";
    return row;
  }

 private:
  const TestBed& bed_;
  const ObservedBed& observed_;
  const TablesParams& params_;
  std::map<std::string, std::string>& stopped_;
  std::map<std::string, Row> rows_;
};

std::vector<std::string> cells(const std::string& mesh, const std::string& noise, const std::string& method,
                               const Row& row, const TestBed& bed) {
  if (row.status != "ok") {
    return {mesh, noise, method, row.status, "-", "-", "-", "-", "-", "-", "-", formatNumber(row.result.seconds, 2),
            "-",  "-",   "-",    "-"};
  }
  const MethodResult& r = row.result;
  const Score s = scoreColors(bed.truth, r.values, r.colored);
  return {mesh,
          noise,
          method,
          row.status,
          formatNumber(s.aep, 3),
          formatNumber(s.rep, 4),
          formatNumber(s.psnr, 2),
          formatNumber(s.ciede2000, 3),
          formatNumber(s.coverage, 4),
          formatNumber(s.aep_gain, 3),
          formatNumber(s.rep_gain, 4),
          formatNumber(r.seconds, 2),
          formatNumber(r.edges_per_point, 2),
          formatNumber(100 * r.unanchored_share, 3),
          formatNumber(r.reprojection_error, 3),
          formatNumber(100 * r.gain_error, 2)};
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

/// Rows of at most five pictures.
cv::Mat arrange(std::vector<cv::Mat> pictures, std::vector<std::string> captions) {
  constexpr std::size_t kAcross = 5;
  cv::Mat all;
  while (pictures.size() % kAcross != 0) {
    pictures.emplace_back(pictures[0].size(), pictures[0].type(), cv::Scalar(255, 255, 255));
    captions.emplace_back("");
  }
  for (std::size_t at = 0; at < pictures.size(); at += kAcross) {
    const auto begin = static_cast<std::ptrdiff_t>(at), end = static_cast<std::ptrdiff_t>(at + kAcross);
    const cv::Mat row = besideEachOther({pictures.begin() + begin, pictures.begin() + end},
                                        {captions.begin() + begin, captions.begin() + end});
    if (all.empty()) {
      all = row;
    } else {
      cv::vconcat(all, row, all);
    }
  }
  return all;
}

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
  for (const std::string& path : paths) meshes.push_back(readMesh(path));
  return meshes;
}

Table1 makeTable1(const std::vector<Mesh>& meshes, const TablesParams& params, const Callbacks& callbacks) {
  Table1 result;
  result.table.header = {"mesh",
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
  std::vector<cv::Mat> pictures;
  std::vector<std::string> captions;
  std::size_t done = 0;
  const std::size_t total = meshes.size() * noiseKinds(params.noise).size() * methodNames().size();
  for (const Mesh& mesh : meshes) {
    const TestBed clean = renderTestBed(mesh, params.bed);
    std::map<std::string, std::string> stopped;
    for (const NoiseKind& kind : noiseKinds(params.noise)) {
      const TestBed bed = addNoise(clean, kind.params, params.bed.seed, params.bed.num_threads);
      const ObservedBed observed = observeBed(bed, bed.poses, {}, params.method);
      Rows rows(bed, observed, params, stopped);
      const bool closeups = &mesh == &meshes.front() && kind.name == "both";
      // With the truth two rows of five.
      static const std::set<std::string> kShown = {"closest", "mean",   "median", "5-NN",   "20-NN",
                                                   "DT",      "1-pass", "4-pass", "default"};
      if (closeups) {
        pictures.push_back(drawCloseup(bed, bed.truth));
        captions.emplace_back("truth");
      }
      for (const std::string& method : methodNames()) {
        if (callbacks.cancelled && callbacks.cancelled()) throw Cancelled();
        const Row& row = rows.of(method);
        result.table.add(cells(mesh.name, kind.name, method, row, bed));
        if (closeups && row.status == "ok" && kShown.count(method) != 0) {
          pictures.push_back(drawCloseup(bed, row.result.values));
          captions.push_back(method);
        }
        if (callbacks.progress) callbacks.progress({"table 1", ++done, total, 0, -1});
      }
    }
  }
  result.closeup = arrange(pictures, captions);
  return result;
}

}  // namespace cloud_colorizer
