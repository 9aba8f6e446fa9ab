// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause
#include "map/fingerprint.hpp"

#include <cstdint>
#include <filesystem>
#include <set>
#include <sstream>

namespace cloud_colorizer {
namespace {

/// To be raised when a stage gives other results than before, so that files of an older program are not used.
constexpr std::uint64_t kStagesVersion = 9;

/// FNV-1a, 64 bit.
class Hash {
 public:
  template <class T>
  Hash& add(const T* data, std::size_t count) {
    const auto* bytes = reinterpret_cast<const unsigned char*>(data);
    for (std::size_t i = 0; i < count * sizeof(T); ++i) value_ = (value_ ^ bytes[i]) * 0x100000001b3ULL;
    return *this;
  }
  Hash& add(const std::string& text) { return add(text.data(), text.size()); }
  template <class T>
  Hash& addValue(const T& value) {
    return add(&value, 1);
  }
  std::uint64_t value() const { return value_; }

 private:
  std::uint64_t value_ = 0xcbf29ce484222325ULL;
};

std::string line(const char* name, std::uint64_t hash) {
  std::ostringstream text;
  text << name << ": " << std::hex << hash << '\n';
  return text.str();
}

/// The named parameters, or all but the named ones.
std::string paramsText(const Params& params, const std::set<std::string>& names, bool all_but) {
  std::string text;
  for (const auto& param : describeParams(params)) {
    if ((names.count(param.name) == 0) == all_but) text += param.name + ": " + param.value + '\n';
  }
  return text;
}

/// The images that are used, and the masks.
std::string imagesKey(const Recording& recording, const ViewList& damaged) {
  Hash hash;
  std::error_code error;
  for (const View& view : recording.views()) {
    hash.add(view.image).addValue(view.camera);
    if (view.mask.empty()) continue;
    const std::string path = recording.directory() + "/" + view.mask;
    hash.addValue(std::filesystem::file_size(path, error));
    hash.addValue(std::filesystem::last_write_time(path, error).time_since_epoch().count());
  }
  for (const std::uint32_t view : damaged) hash.addValue(view);
  for (const auto& camera : recording.cameras()) {
    hash.add(camera.mask).addValue(std::filesystem::file_size(recording.directory() + "/" + camera.mask, error));
    const Quantity& quantity = camera.quantity;
    hash.addValue(quantity.kind).add(quantity.name).addValue(quantity.scale).addValue(quantity.offset);
  }
  return line("images and masks", hash.value());
}

std::string visibilityKey(const Recording& recording, const Params& params) {
  Hash hash;
  hash.addValue(recording.tileSize());
  for (const Tile& tile : recording.tiles()) hash.add(tile.index.data(), 3).addValue(tile.num_points);
  for (const Scan& scan : recording.scans()) hash.addValue(scan.stamp).add(scan.map_from_sensor.matrix().data(), 16);
  for (const auto& camera : recording.cameras()) {
    const Intrinsics& k = camera.intrinsics;
    hash.addValue(k.width).addValue(k.height).addValue(k.fx).addValue(k.fy).addValue(k.cx).addValue(k.cy);
    hash.addValue(k.model).add(k.distortion.data(), k.distortion.size());
  }
  return line("points and cameras", hash.value()) +
         paramsText(params, {"depth_cell_size", "depth_tolerance", "depth_edge_guard", "max_view_distance"}, false) +
         line("scans are used", params.record.scan_resolution > 0);
}

}  // namespace

std::string shortName(const std::string& key) {
  std::ostringstream text;
  text << std::hex << Hash().add(key).value();
  return text.str();
}

std::string imageFilesKey(const Recording& recording) {
  Hash hash;
  for (const View& view : recording.views()) {
    const std::string path = recording.directory() + "/" + view.image;
    std::error_code error;
    hash.add(view.image).addValue(view.camera).addValue(std::filesystem::file_size(path, error));
    hash.addValue(std::filesystem::last_write_time(path, error).time_since_epoch().count());
  }
  for (const auto& camera : recording.cameras()) {
    hash.addValue(camera.intrinsics.width).addValue(camera.intrinsics.height);
  }
  return line("version of the stages", kStagesVersion) + line("image files", hash.value());
}

bool findsMoving(const Recording& recording, const Params& params) {
  return params.colorize.moving != Moving::kKeep && params.record.scan_resolution > 0 && !recording.scans().empty();
}

std::string movingKey(const Recording& recording, const Params& params) {
  std::string asked = line("moving things are found", findsMoving(recording, params));
  if (!findsMoving(recording, params)) return asked;
  Hash hash;
  for (const Scan& scan : recording.scans()) hash.add(scan.image).add(scan.map_from_sensor.matrix().data(), 16);
  return asked + line("version of the stages", kStagesVersion) + line("scans", hash.value()) +
         paramsText(params, {"max_range"}, false);
}

std::string surfelsKey(const Recording& recording, const Params& params) {
  Hash poses;
  for (const View& view : recording.views()) {
    poses.add(view.map_from_camera.matrix().data(), 16).addValue(view.stamp).add(view.readout_motion.data(), 6);
  }
  return line("version of the stages", kStagesVersion) + line("poses of the recording", poses.value()) +
         paramsText(params, {"clear_radius"}, false) + movingKey(recording, params);
}

std::string alignmentKey(const Recording& recording, const Params& params, const ViewList& damaged) {
  std::set<std::string> names = {"align_poses"};
  visitAlignmentParams(params.alignment, [&](const char* name, const auto&, const char*) { names.insert(name); });
  return surfelsKey(recording, params) + visibilityKey(recording, params) + imagesKey(recording, damaged) +
         paramsText(params, names, false);
}

std::string depthKey(const Recording& recording, const Params& params, const std::vector<CorrectedView>& views) {
  Hash poses;
  for (const auto& view : views) poses.add(view.map_from_camera.matrix().data(), 16);
  return surfelsKey(recording, params) + visibilityKey(recording, params) + line("poses", poses.value());
}

std::string colorsKey(const Recording& recording, const Params& params, const ViewList& damaged,
                      const std::vector<CorrectedView>& views) {
  // These do not change the colour of a tile.
  const std::set<std::string> without = {"num_threads", "memory_limit",    "uncolored", "fill_distance",
                                         "crs",         "scan_resolution", "moving",    "tone"};
  Hash exposures;
  for (const auto& view : views) {
    exposures.add(view.exposure.gain.data(), static_cast<std::size_t>(view.exposure.gain.size()));
    exposures.add(view.exposure.offset.data(), static_cast<std::size_t>(view.exposure.offset.size()));
    exposures.add(view.exposure.vignetting.data(), 2);
    exposures.addValue(view.weight);
  }
  return depthKey(recording, params, views) + imagesKey(recording, damaged) + paramsText(params, without, true) +
         line("exposures", exposures.value());
}

}  // namespace cloud_colorizer
