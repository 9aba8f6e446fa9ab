// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause
#include "cloud_colorizer/recording/recording.hpp"

#include <algorithm>
#include <array>
#include <cstring>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "base/file_io.hpp"
#include "cloud_colorizer/base/check.hpp"
#include "recording/recording_files.hpp"
#include "recording/recording_tables.hpp"
#include "recording/tile_file.hpp"

namespace cloud_colorizer {

namespace {

/// libjpeg paints what is missing in grey and says nothing: a whole file has its end marker behind its scan.
bool isTornJpeg(const std::vector<std::uint8_t>& bytes) {
  constexpr std::array<std::uint8_t, 2> kStart{0xFF, 0xD8}, kScan{0xFF, 0xDA}, kEnd{0xFF, 0xD9};
  if (bytes.size() < 2 || !std::equal(kStart.begin(), kStart.end(), bytes.begin())) return false;
  const auto scan = std::find_end(bytes.begin(), bytes.end(), kScan.begin(), kScan.end());
  return std::search(scan, bytes.end(), kEnd.begin(), kEnd.end()) == bytes.end();
}

/// Empty when the file is no whole image.
cv::Mat decode(const std::string& path, int flags) {
  const auto bytes = readFile(path);
  if (bytes.empty() || isTornJpeg(bytes)) return {};
  try {
    return cv::imdecode(bytes, flags);
  } catch (const cv::Exception&) {  // such as a size beyond all bounds; it does not know the path
    return {};
  }
}

cv::Mat decodeImage(const std::string& path, int flags, const Intrinsics& intrinsics) {
  cv::Mat image = decode(path, flags);
  require(!image.empty(), "image ", path, " cannot be decoded: it is no image of a known format, or damaged");
  require(image.cols == intrinsics.width && image.rows == intrinsics.height, "image ", path, " is ", image.cols, " x ",
          image.rows, ", but its camera in cameras.yaml has ", intrinsics.width, " x ", intrinsics.height);
  return image;
}

}  // namespace

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
const Eigen::Vector3d& Recording::origin() const {
  return state_->origin;
}
double Recording::voxelSize() const {
  return state_->info.voxel_size;
}
double Recording::tileSize() const {
  return state_->info.tile_size;
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

cv::Mat Recording::readImage(std::size_t view) const {
  const auto& entry = state_->views.at(view);
  cv::Mat image = decodeImage(state_->directory + '/' + entry.image, cv::IMREAD_COLOR | cv::IMREAD_IGNORE_ORIENTATION,
                              state_->cameras.at(entry.camera).intrinsics);
  cv::cvtColor(image, image, cv::COLOR_BGR2RGB);
  return image;
}

cv::Mat Recording::readMask(std::size_t camera) const {
  const auto& entry = state_->cameras.at(camera);
  if (entry.mask.empty()) return {};
  return decodeImage(state_->directory + '/' + entry.mask, cv::IMREAD_GRAYSCALE | cv::IMREAD_IGNORE_ORIENTATION,
                     entry.intrinsics);
}

cv::Mat1w Recording::readScan(std::size_t scan) const {
  const std::string path = state_->directory + '/' + state_->scans.at(scan).image;
  cv::Mat panorama = decode(path, cv::IMREAD_UNCHANGED);
  require(panorama.type() == CV_16UC1 && !panorama.empty(), "scan ", path,
          " is damaged: it is no image of 16 bit ranges; delete scans.csv to colour without scans");
  return panorama;
}

}  // namespace cloud_colorizer
