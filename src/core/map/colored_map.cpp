// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause
#include <filesystem>
#include <nlohmann/json.hpp>
#include <numeric>
#include <set>

#include "base/file_io.hpp"
#include "base/progress.hpp"
#include "base/text.hpp"
#include "cloud_colorizer/base/check.hpp"
#include "cloud_colorizer/cloud/cloud_io.hpp"
#include "map/colored_tiles.hpp"
#include "map/tile_blocks.hpp"
#include "recording/tile_file.hpp"

namespace cloud_colorizer {
namespace {

constexpr std::size_t kMostPointsOfFile = 2000000;  // of several tiles: what editors and viewers open with ease

}  // namespace

void forEachColoredTile(const Recording& recording, const Params& params, bool relative,
                        const std::function<void(const Cloud&)>& visit) {
  ColoredTiles(recording, params).visit(allTiles(recording.tiles()), relative, visit);
}

namespace {

/// Of the points of some tiles, m, in the map frame.
Eigen::AlignedBox3d boxAround(const Recording& recording, const TileIds& tiles) {
  Eigen::AlignedBox3d box;
  for (const std::size_t tile : tiles) {
    const Points points = recording.readPoints(tile);
    if (points.cols() == 0) continue;
    box.extend(points.rowwise().minCoeff().cast<double>() + recording.origin());
    box.extend(points.rowwise().maxCoeff().cast<double>() + recording.origin());
  }
  return box;
}

/// PCL reads x, y and z as floats only, which keep no centimetres of UTM coordinates. So the points of a PCD are
/// relative to the recording's origin, which stands beside it; CloudReader adds it again.
void writeOrigin(const std::string& path, const Eigen::Vector3d& origin, const Callbacks& callbacks) {
  const std::string file = originFile(path);
  if (origin.isZero()) {
    std::error_code ignored;
    if (lowerExtension(path) == ".pcd") std::filesystem::remove(file, ignored);  // of an earlier map
    return;
  }
  std::string text;
  for (int axis = 0; axis < 3; ++axis) text += (axis > 0 ? " " : "") + formatDouble(origin[axis]);
  const std::string line = text + '\n';
  writeFileAtomically(file, line.data(), line.size());
  if (callbacks.log) callbacks.log(LogLevel::kInfo, path + " is relative to " + text + ", as " + file + " says");
}

/// Saves some tiles of a map as one file; returns the number of points.
class MapWriter {
 public:
  MapWriter(const Recording& recording, const Params& params, const Callbacks& callbacks)
      : recording_(recording), params_(params), callbacks_(callbacks), tiles_(recording, params) {}

  std::size_t countPoints(const TileIds& tiles) const { return tiles_.countPoints(tiles); }

  void save(const TileIds& tiles, std::size_t num_points, const std::string& path, ProgressMeter& progress) {
    const bool is_far = !recording_.origin().isZero();
    const bool is_relative = is_far && lowerExtension(path) == ".pcd";
    const bool needs_box = lowerExtension(path) == ".las";
    CloudWriter writer(path, num_points, coloredFields(recording_, params_), is_far && !is_relative,
                       needs_box ? boxAround(recording_, tiles) : Eigen::AlignedBox3d(),
                       coloredCrs(recording_, params_));
    tiles_.visit(tiles, is_relative, [&](const Cloud& cloud) {
      writer.write(cloud);
      progress.add(static_cast<std::size_t>(cloud.positions.cols()));
    });
    writeOrigin(path, is_relative ? recording_.origin() : Eigen::Vector3d::Zero().eval(), callbacks_);
    writer.finish();
  }

 private:
  const Recording& recording_;
  const Params& params_;
  const Callbacks& callbacks_;
  ColoredTiles tiles_;
};

/// Files of an earlier map that this one has not; its list names them.
void removeOldFiles(const std::string& directory, const std::string& list, const std::set<std::string>& written) {
  if (!std::filesystem::exists(list)) return;
  const std::vector<std::uint8_t> bytes = readFile(list);
  const auto old = nlohmann::json::parse(bytes.begin(), bytes.end(), nullptr, false);
  if (!old.is_object() || !old.contains("tiles") || !old["tiles"].is_array()) return;
  for (const auto& tile : old["tiles"]) {
    const bool has_name = tile.is_object() && tile.contains("file") && tile["file"].is_string();
    const std::string name = has_name ? tile["file"].get<std::string>() : "";
    const bool is_plain = !name.empty() && std::filesystem::path(name).filename() == name;
    std::error_code ignored;
    if (!is_plain || written.count(name) != 0) continue;
    std::filesystem::remove(directory + '/' + name, ignored);
    std::filesystem::remove(originFile(directory + '/' + name), ignored);
  }
}

}  // namespace

namespace {

/// What the classes of the map are stands beside it: map.label.txt of map.ply.
void copyNames(const Recording& recording, const std::string& path) {
  namespace fs = std::filesystem;
  for (const Quantity& quantity : recording.quantities()) {
    if (quantity.names.empty()) continue;
    const std::vector<std::uint8_t> bytes = readFile(recording.directory() + '/' + quantity.names);
    const std::string extension = '.' + quantity.name + fs::path(quantity.names).extension().string();
    writeFileAtomically(fs::path(path).replace_extension(extension).string(), bytes.data(), bytes.size());
  }
}

}  // namespace

std::size_t saveColored(const Recording& recording, const Params& params, const std::string& path,
                        const Callbacks& callbacks) {
  CloudWriter::checkPath(path);
  MapWriter writer(recording, params, callbacks);
  const TileIds tiles = allTiles(recording.tiles());
  const std::size_t num_points = writer.countPoints(tiles);
  ProgressMeter progress(callbacks, "save", num_points);
  writer.save(tiles, num_points, path, progress);
  copyNames(recording, path);
  return num_points;
}

std::size_t saveColoredTiles(const Recording& recording, const Params& params, const std::string& directory,
                             const std::string& extension, const Callbacks& callbacks) {
  std::filesystem::create_directories(directory);
  Callbacks silent = callbacks;
  silent.log = {};
  MapWriter writer(recording, params, silent);
  const std::vector<TileIds> cubes = cubesOfTiles(recording, allTiles(recording.tiles()), kMostPointsOfFile);
  std::vector<std::size_t> counts;
  counts.reserve(cubes.size());
  for (const TileIds& cube : cubes) counts.push_back(writer.countPoints(cube));
  const std::size_t num_points = std::accumulate(counts.begin(), counts.end(), std::size_t{0});
  ProgressMeter progress(callbacks, "save tiles", num_points);
  nlohmann::ordered_json tiles = nlohmann::json::array();
  std::set<std::string> names;
  for (std::size_t i = 0; i < cubes.size(); ++i) {
    if (counts[i] == 0) continue;
    const std::string name = tileName(recording.tiles()[cubes[i].front()].index) + extension;
    writer.save(cubes[i], counts[i], directory + '/' + name, progress);
    const Eigen::AlignedBox3d box = boxAround(recording, cubes[i]);
    const auto corner = [](const Eigen::Vector3d& at) { return nlohmann::json{at.x(), at.y(), at.z()}; };
    tiles.push_back({{"file", name}, {"points", counts[i]}, {"min", corner(box.min())}, {"max", corner(box.max())}});
    names.insert(name);
  }
  const std::string list = directory + "/tiles.json";
  removeOldFiles(directory, list, names);
  const std::string text = nlohmann::ordered_json{{"points", num_points}, {"tiles", tiles}}.dump(1) + '\n';
  writeFileAtomically(list, text.data(), text.size());
  return num_points;
}

std::vector<Eigen::Isometry3d> usedPoses(const Recording& recording, const Params& params) {
  const FolderLock lock(recording.directory(), false);
  Workspace work(recording, params);
  work.restoreDamagedViews();
  const bool aligned = work.restoreCorrections();
  require(aligned || !work.params().aligns() || !std::filesystem::exists(work.files().pathOf(kAlignmentFolder)),
          "the poses in ", work.files().pathOf(kAlignmentFolder),
          " were found with other parameters or from other views, or are damaged; colour the recording again first");
  std::vector<Eigen::Isometry3d> poses;
  for (const CorrectedView& view : work.corrections()) poses.push_back(view.map_from_camera);
  return poses;
}

}  // namespace cloud_colorizer
