// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause
#include "cloud_colorizer/recording/recording.hpp"

#include <algorithm>
#include <cstring>
#include <opencv2/imgcodecs.hpp>

#include "base/file_io.hpp"
#include "cloud_colorizer/base/check.hpp"
#include "recording/image_files.hpp"
#include "recording/recording_files.hpp"
#include "recording/recording_tables.hpp"
#include "recording/tile_file.hpp"

namespace cloud_colorizer {

Recording Recording::open(const std::string& directory) {
  require(hasRecording(directory), directory,
          " is not a recording: it has no recording.yaml; give the directory that the node, colorize_bag or "
          "colorize_map recorded into");
  auto state = std::make_shared<State>();
  state->directory = directory;
  // Another process may be recording: it writes a camera before its views, so the views are read first.
  state->views = readViews(directory).rows;
  state->scans = readScans(directory).rows;
  state->cameras = readCameras(directory);
  for (const auto& view : state->views) {
    require(view.camera < state->cameras.size(), directory, "/views.csv is damaged: camera ", view.camera, " of image ",
            view.image, " is not in cameras.yaml");
  }
  state->info = readInfo(directory);
  state->origin = state->info.origin.value_or(Eigen::Vector3d::Zero());
  state->fields = state->info.fields.value_or(std::vector<Field>{});
  if (state->info.fields) state->tiles = listTiles(directory, state->fields);
  for (const auto& tile : state->tiles) state->num_points += tile.num_points;
  Recording recording;
  recording.state_ = std::move(state);
  return recording;
}

const std::string& Recording::directory() const {
  return state_->directory;
}
const std::string& Recording::mapFrame() const {
  return state_->info.map_frame;
}
const std::string& Recording::crs() const {
  return state_->info.crs;
}
const Eigen::Vector3d& Recording::origin() const {
  return state_->origin;
}
double Recording::voxelSize() const {
  return state_->info.voxel_size;
}
double Recording::tileSize() const {
  return state_->info.tile_size;
}
double Recording::maxRange() const {
  return state_->info.max_range;
}
const std::vector<Field>& Recording::fields() const {
  return state_->fields;
}
const std::vector<RecordedCamera>& Recording::cameras() const {
  return state_->cameras;
}
const std::vector<View>& Recording::views() const {
  return state_->views;
}
const std::vector<Scan>& Recording::scans() const {
  return state_->scans;
}
const std::vector<Tile>& Recording::tiles() const {
  return state_->tiles;
}
Eigen::AlignedBox3f Recording::tileBox(std::size_t tile) const {
  const TileIndex& index = state_->tiles[tile].index;
  const Eigen::Vector3d low = Eigen::Vector3d(index[0], index[1], index[2]) * tileSize();
  const Eigen::Vector3d high = low + Eigen::Vector3d::Constant(tileSize());
  return {low.cast<float>(), high.cast<float>()};
}
std::size_t Recording::numPoints() const {
  return state_->num_points;
}

Points Recording::readPoints(std::size_t tile) const {
  const auto& entry = state_->tiles.at(tile);
  const auto bytes = readTileColumns(state_->directory, entry, state_->fields, 0, kPositionSize);
  Points points(3, static_cast<Eigen::Index>(entry.num_points));
  if (!bytes.empty()) std::memcpy(points.data(), bytes.data(), bytes.size());
  return points;
}

std::vector<std::uint8_t> Recording::readRecords(std::size_t tile) const {
  return readTileColumns(state_->directory, state_->tiles.at(tile), state_->fields, kPositionSize,
                         recordSize(state_->fields));
}

ViewPixels Recording::readPixels(std::size_t view) const {
  const auto& entry = state_->views.at(view);
  const Intrinsics& intrinsics = state_->cameras.at(entry.camera).intrinsics;
  ViewPixels pixels =
      decodePixels(state_->directory + '/' + entry.image, intrinsics, state_->cameras[entry.camera].quantity.kind);
  addMask(readMask(entry.camera), pixels.mask);
  if (!entry.mask.empty()) addMask(decodeMask(state_->directory + '/' + entry.mask, intrinsics), pixels.mask);
  return pixels;
}

const Quantity& Recording::quantityOf(std::size_t view) const {
  return state_->cameras[state_->views[view].camera].quantity;
}

bool Recording::hasColors() const {
  return std::any_of(state_->cameras.begin(), state_->cameras.end(),
                     [](const RecordedCamera& camera) { return camera.quantity.kind == ImageKind::kColor; });
}

std::vector<Quantity> Recording::quantities() const {
  std::vector<Quantity> quantities;
  for (const RecordedCamera& camera : state_->cameras) {
    const bool is_known = std::any_of(quantities.begin(), quantities.end(),
                                      [&](const Quantity& known) { return isSame(known, camera.quantity); });
    if (camera.quantity.kind != ImageKind::kColor && !is_known) quantities.push_back(camera.quantity);
  }
  return quantities;
}

cv::Mat Recording::readMask(std::size_t camera) const {
  const auto& entry = state_->cameras.at(camera);
  if (entry.mask.empty()) return {};
  return decodeMask(state_->directory + '/' + entry.mask, entry.intrinsics);
}

cv::Mat1w Recording::readScan(std::size_t scan) const {
  const std::string path = state_->directory + '/' + state_->scans.at(scan).image;
  cv::Mat panorama = decodeFile(path, cv::IMREAD_UNCHANGED);
  require(panorama.type() == CV_16UC1 && !panorama.empty(), "scan ", path,
          " is damaged: it is no image of 16 bit ranges; delete scans.csv to colour without scans");
  return panorama;
}

}  // namespace cloud_colorizer
