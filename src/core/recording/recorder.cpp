// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause
#include "cloud_colorizer/recording/recorder.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <opencv2/imgcodecs.hpp>
#include <optional>
#include <set>

#include "base/file_io.hpp"
#include "base/text.hpp"
#include "cloud_colorizer/base/check.hpp"
#include "cloud_colorizer/visibility/empty_space.hpp"
#include "recording/camera_list.hpp"
#include "recording/cloud_log.hpp"
#include "recording/image_files.hpp"
#include "recording/place_points.hpp"
#include "recording/recording_files.hpp"
#include "recording/recording_lock.hpp"
#include "recording/recording_tables.hpp"
#include "recording/scan_log.hpp"
#include "recording/tile_file.hpp"
#include "recording/tile_grid.hpp"
#include "recording/tile_writer.hpp"

namespace cloud_colorizer {

namespace {

using Clock = std::chrono::steady_clock;

constexpr double kFlushPeriod = 0.5;                  ///< s
constexpr std::size_t kMaxPendingBytes = 64'000'000;  ///< of points that are not yet in a file
constexpr double kMaxOriginDistance = 5000;           ///< m; positions nearer to the map's origin keep it

void requirePose(const Eigen::Isometry3d& pose, const char* what) {
  const Eigen::Matrix3d error = pose.linear() * pose.linear().transpose() - Eigen::Matrix3d::Identity();
  require<std::invalid_argument>(pose.matrix().allFinite() && error.norm() < 1e-3 && pose.linear().determinant() > 0,
                                 what, " must be finite and a rigid motion");
}

}  // namespace

struct Recorder::Impl {
  std::string directory;
  RecordParams params;
  RecordingLock lock;
  RecordingInfo info;
  CameraList cameras;
  ScanLog scans;
  std::vector<View> views;
  TableWriter views_table;
  std::optional<TableWriter> readouts_table;  ///< from the first view of a rolling shutter on
  std::optional<CloudLog> cloud_log;
  std::multiset<std::pair<std::uint32_t, std::string>>
      earlier_views;                ///< camera and stamp of what an earlier program recorded
  std::optional<TileWriter> tiles;  ///< from the moment the fields are known
  std::vector<PlacedPoint> placed;  ///< kept between clouds, as fresh memory of this size is slow
  bool has_torn_cloud = false;      ///< the last one's points are not all there
  Clock::time_point last_flush = Clock::now();

  Impl(const std::string& dir, const std::string& map_frame, const RecordParams& record_params);
  void resume(const std::string& map_frame);
  void fixOrigin(const Eigen::Vector3d& position);
  void fixFields(const std::vector<Field>& fields);
  void openTiles(const std::vector<Tile>& saved);
  void writeReadout(const View& next_view);
  void saveTiles();
  void flush();
  void flushWhenDue();
};

Recorder::Impl::Impl(const std::string& dir, const std::string& map_frame, const RecordParams& record_params)
    : directory(dir),
      params(record_params),
      lock((params.check(), dir)),
      info(hasRecording(dir) ? readInfo(dir) : newInfo(dir, map_frame, params)),
      cameras(dir, readCameras(dir)),
      scans(dir, params),
      views_table(TableWriter::ofViews(dir)) {
  resume(map_frame);
  cloud_log.emplace(directory, info.voxel_size == 0);
  if (hasReadouts(directory)) readouts_table = TableWriter::ofReadouts(directory);
}

void Recorder::Impl::resume(const std::string& map_frame) {
  require(info.map_frame == map_frame, "cannot continue the recording ", directory, ": its map frame is \"",
          info.map_frame, "\", not \"", map_frame, "\"; set map_frame, or record into another directory");
  require(info.voxel_size == params.voxel_size && info.tile_size == defaultTileSize(params),
          "cannot continue the recording ", directory, ": it was made with voxel_size = ", info.voxel_size,
          " and tile_size = ", info.tile_size, ", not ", params.voxel_size, " and ", defaultTileSize(params),
          "; set these, or record into another directory");
  if (info.voxel_size == 0 && info.fields) undoTiles(directory, *info.fields);
  const auto recording = Recording::open(directory);
  views = recording.views();
  for (const View& view : views) earlier_views.emplace(view.camera, formatFixed(view.stamp, 9));
  std::filesystem::create_directories(directory + "/tiles");
  if (info.fields) openTiles(recording.tiles());
}

void Recorder::Impl::openTiles(const std::vector<Tile>& saved) {
  tiles.emplace(directory, info, static_cast<std::size_t>(params.max_open_tiles), saved,
                [this](const TileIndex& tile, std::uint64_t num_points) { cloud_log->noteGrowth(tile, num_points); });
}

/// Before the view itself, which is known when its line is there. From the first one on all views have theirs: a killed
/// program may have left one without its view.
void Recorder::Impl::writeReadout(const View& next_view) {
  if (!readouts_table) readouts_table = TableWriter::ofReadouts(directory);
  readouts_table->append(readoutLine(views.size(), next_view.readout_motion));
}

/// Floats are exact to half a millimetre within 5 km; farther from the map's origin the recording gets its own.
void Recorder::Impl::fixOrigin(const Eigen::Vector3d& position) {
  if (info.origin) return;
  const Eigen::Vector3d rounded = (position / 1000).array().round() * 1000;
  info.origin = position.norm() <= kMaxOriginDistance ? Eigen::Vector3d::Zero() : rounded;
  writeInfo(directory, info);
}

void Recorder::Impl::fixFields(const std::vector<Field>& fields) {
  if (info.fields) return;
  checkFields(fields);
  info.fields = fields;
  writeInfo(directory, info);
  openTiles({});
}

void Recorder::Impl::saveTiles() {
  // Another recording may have taken the name; these points are not its own.
  require(!tiles || tiles->numPendingBytes() == 0 || lock.isInPlace(), "the recording ", directory,
          " was deleted or moved away while points were recorded");
  if (tiles) tiles->flush();
}

void Recorder::Impl::flush() {
  saveTiles();
  cloud_log->commit();
  last_flush = Clock::now();
}

void Recorder::Impl::flushWhenDue() {
  const bool is_due = std::chrono::duration<double>(Clock::now() - last_flush).count() > kFlushPeriod;
  if (is_due || (tiles && tiles->numPendingBytes() > kMaxPendingBytes)) flush();
}

Recorder::Recorder(const std::string& directory, const std::string& map_frame, const RecordParams& params)
    : impl_(std::make_unique<Impl>(directory, map_frame, params)) {}

Recorder::~Recorder() {
  if (!impl_) return;
  try {
    impl_->has_torn_cloud ? impl_->saveTiles() : impl_->flush();
  } catch (const std::exception& error) {
    // A destructor cannot pass it on; whoever must know calls flush() before.
    std::fprintf(stderr, "the last points are lost: %s\n", error.what());
  }
}

void Recorder::setCrs(const std::string& crs) {
  impl_->info.crs = crs;
  writeInfo(impl_->directory, impl_->info);
}

std::uint32_t Recorder::setCamera(const std::string& name, const Intrinsics& intrinsics, const Quantity& quantity) {
  return impl_->cameras.find(name, intrinsics, quantity);
}

void Recorder::setMask(std::uint32_t camera, const cv::Mat1b& mask) {
  impl_->cameras.setMask(camera, mask);
}

Recorder::InsertCounts Recorder::addCloud(const Cloud& cloud, const Eigen::Isometry3d& map_from_sensor,
                                          const std::optional<CloudSource>& source) {
  auto& impl = *impl_;
  checkCloud(cloud);
  requirePose(map_from_sensor, "the pose of a cloud");
  impl.flushWhenDue();  // after a failed flush this throws before more is held in memory
  InsertCounts counts;
  if (!impl.info.origin) {
    if (const auto position = firstInRange(cloud, map_from_sensor, impl.params)) impl.fixOrigin(*position);
  }
  Eigen::Isometry3d relative = map_from_sensor;
  if (impl.info.origin) relative.translation() -= *impl.info.origin;
  placePoints(cloud, relative, impl.params, TileGrid(impl.info.voxel_size, impl.info.tile_size), impl.placed, counts);
  if (!impl.placed.empty()) {
    impl.fixFields(cloud.fields);
    const RecordMap record_map(cloud.fields, *impl.info.fields);
    counts.fields_dropped = record_map.dropped();
    counts.fields_missing = record_map.missing();
    impl.has_torn_cloud = true;
    counts.added = impl.tiles->insert(impl.placed, cloud.records.data(), recordSize(cloud.fields), record_map);
    impl.has_torn_cloud = false;
    counts.voxel_taken = impl.placed.size() - counts.added;
  }
  if (source) impl.cloud_log->add(*source);
  impl.flushWhenDue();
  return counts;
}

bool Recorder::recognizeCloud(const CloudSource& source) {
  return impl_->cloud_log->recognize(source);
}

bool Recorder::recognizeView(std::uint32_t camera, double stamp) {
  const auto found = impl_->earlier_views.find({camera, formatFixed(stamp, 9)});
  if (found == impl_->earlier_views.end()) return false;
  impl_->earlier_views.erase(found);
  return true;
}

std::size_t Recorder::addView(std::uint32_t camera, double stamp, const Eigen::Isometry3d& map_from_camera,
                              const std::vector<std::uint8_t>& encoded_image, const std::string& extension,
                              const cv::Mat1b& mask, const Twist& readout_motion) {
  auto& impl = *impl_;
  require<std::invalid_argument>(camera < impl.cameras.cameras().size(), "there is no camera ", camera,
                                 " for this view");
  require<std::invalid_argument>(std::isfinite(stamp), "the stamp of a view must be finite, not ", stamp);
  require<std::invalid_argument>(isFileName(extension) && extension.size() <= 8, "image extension \"", extension,
                                 "\" must be a word such as jpg or png");
  require<std::invalid_argument>(!encoded_image.empty(), "the image of a view of ", impl.cameras.cameras()[camera].name,
                                 " has no bytes");
  require<std::invalid_argument>(readout_motion.allFinite(), "the motion while a view is read is not finite");
  requirePose(map_from_camera, "the pose of a view");
  impl.fixOrigin(map_from_camera.translation());
  View view;
  view.camera = camera;
  view.stamp = stamp;
  view.map_from_camera = map_from_camera;
  view.map_from_camera.translation() -= *impl.info.origin;
  view.readout_motion = readout_motion;
  const RecordedCamera& recorded = impl.cameras.cameras()[camera];
  view.image = "images/" + recorded.name + '/' + sixDigits(impl.views.size()) + '.' + extension;
  std::filesystem::remove(impl.directory + '/' + maskFileOf(view.image));  // of a program that was killed
  if (!mask.empty()) {
    view.mask = maskFileOf(view.image);
    writeMask(impl.directory + '/' + view.mask, mask, recorded.intrinsics, "a view of " + recorded.name);
  }
  writeFileAtomically(impl.directory + '/' + view.image, encoded_image.data(), encoded_image.size());
  if (impl.readouts_table || !readout_motion.isZero(0)) impl.writeReadout(view);
  impl.views_table.append(viewLine(view));
  view.map_from_camera = poseInTable(view.map_from_camera);  // the same map from memory and from the files
  impl.views.push_back(std::move(view));
  impl.flushWhenDue();
  return impl.views.size() - 1;
}

void Recorder::addScan(const std::string& sensor, double stamp, const Eigen::Matrix3Xd& positions,
                       const Eigen::Isometry3d& map_from_sensor) {
  requirePose(map_from_sensor, "the pose of a scan");
  if (impl_->params.scan_resolution == 0) return;
  impl_->fixOrigin(map_from_sensor.translation());
  impl_->scans.add(sensor, stamp, positions, map_from_sensor, *impl_->info.origin);
}

void Recorder::flush() {
  impl_->flush();
}

bool Recorder::isInPlace() const {
  return impl_->lock.isInPlace();
}

Recording Recorder::snapshot() {
  impl_->flush();
  auto state = std::make_shared<Recording::State>();
  state->directory = impl_->directory;
  state->info = impl_->info;
  state->origin = impl_->info.origin.value_or(Eigen::Vector3d::Zero());
  state->fields = impl_->info.fields.value_or(std::vector<Field>{});
  state->cameras = impl_->cameras.cameras();
  state->views = impl_->views;
  state->scans = impl_->scans.scans();
  if (impl_->tiles) state->tiles = listTiles(state->directory, state->fields);
  for (const auto& tile : state->tiles) state->num_points += tile.num_points;
  Recording recording;
  recording.state_ = std::move(state);
  return recording;
}

std::size_t Recorder::numPoints() const {
  return impl_->tiles ? impl_->tiles->numPoints() : 0;
}
std::size_t Recorder::numViews() const {
  return impl_->views.size();
}

}  // namespace cloud_colorizer
