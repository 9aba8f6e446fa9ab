// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause
#include "cloud_colorizer/recording/recorder.hpp"

#include <fcntl.h>
#include <sys/stat.h>

#include <algorithm>
#include <cctype>
#include <cerrno>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <limits>
#include <map>
#include <opencv2/imgcodecs.hpp>
#include <optional>
#include <set>

#include "base/file_io.hpp"
#include "base/text.hpp"
#include "cloud_colorizer/base/check.hpp"
#include "cloud_colorizer/visibility/empty_space.hpp"
#include "recording/recording_files.hpp"
#include "recording/tile_file.hpp"
#include "recording/tile_grid.hpp"
#include "recording/tile_writer.hpp"

namespace cloud_colorizer {

namespace {

using Clock = std::chrono::steady_clock;

constexpr double kFlushPeriod = 0.5;                  ///< s
constexpr std::size_t kMaxPendingBytes = 64'000'000;  ///< of points that are not yet in a file
constexpr double kMaxOriginDistance = 5000;           ///< m; positions nearer to the map's origin keep it
constexpr double kScanShare = 0.25;                   ///< of the motion between keyframes: between scans

double defaultTileSize(const RecordParams& params) {
  if (params.tile_size > 0) return params.tile_size;
  return params.voxel_size > 0 ? 200 * params.voxel_size : 10;
}

void requirePose(const Eigen::Isometry3d& pose, const char* what) {
  const Eigen::Matrix3d error = pose.linear() * pose.linear().transpose() - Eigen::Matrix3d::Identity();
  require<std::invalid_argument>(pose.matrix().allFinite() && error.norm() < 1e-3 && pose.linear().determinant() > 0,
                                 what, " must be finite and a rigid motion");
}

Intrinsics withoutTrailingZeros(Intrinsics intrinsics) {
  auto& distortion = intrinsics.distortion;
  while (!distortion.empty() && distortion.back() == 0) distortion.pop_back();
  return intrinsics;
}

bool sameIntrinsics(const Intrinsics& a, const Intrinsics& b) {
  return a.width == b.width && a.height == b.height && a.fx == b.fx && a.fy == b.fy && a.cx == b.cx && a.cy == b.cy &&
         a.model == b.model && withoutTrailingZeros(a).distortion == withoutTrailingZeros(b).distortion;
}

bool isFileName(const std::string& name) {
  const auto allowed = [](unsigned char c) { return std::isalnum(c) != 0 || c == '_' || c == '-' || c == '.'; };
  return !name.empty() && name.front() != '.' && std::all_of(name.begin(), name.end(), allowed);
}

/// A new directory, a recording, or what is left of one that crashed at once; never somebody's home.
void prepareDirectory(const std::string& directory) {
  std::error_code error;
  std::filesystem::create_directories(directory, error);
  require(!error, "cannot create the recording ", directory, ": ", error.message());
  if (hasRecording(directory)) return;
  for (const auto& entry : std::filesystem::directory_iterator(directory)) {
    const auto name = entry.path().filename().string();
    require(name == "recorder.lock" || name.rfind("recording.yaml", 0) == 0, "cannot record into ", directory,
            ": it holds other files (", name, ") and no recording.yaml; give a new directory");
  }
}

File lockRecording(const std::string& directory) {
  File lock(directory + "/recorder.lock", O_RDWR | O_CREAT);
  require(lock.tryLock(true), "another program is recording into ", directory,
          "; stop it, or record into another directory");
  return lock;
}

}  // namespace

void RecordParams::check() const {
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  requireInRange("voxel_size", voxel_size, 0.0, 1000.0);
  require<std::invalid_argument>(voxel_size == 0 || voxel_size >= 1e-6, "parameter voxel_size = ", voxel_size,
                                 " must be 0 or at least 1e-6 m");
  requireInRange("min_range", min_range, 0.0, kInfinity);
  requireInRange("max_range", max_range, min_range, kInfinity);
  requireInRange("tile_size", tile_size, 0.0, 1e6);
  requireInRange("keyframe_distance", keyframe_distance, 0.0, kInfinity);
  requireInRange("keyframe_angle", keyframe_angle, 0.0, 360.0);
  require<std::invalid_argument>(scan_resolution == 0 || (scan_resolution >= 0.05 && scan_resolution <= 30),
                                 "parameter scan_resolution = ", scan_resolution, " must be 0 or 0.05 to 30 deg");
  requireInRange("max_open_tiles", max_open_tiles, 1, 1'000'000);
  if (voxel_size == 0 || tile_size == 0) return;
  const double side = tile_size / voxel_size;
  const double whole = std::max(1.0, std::round(side));
  require<std::invalid_argument>(std::abs(side - whole) < 1e-6 * whole, "parameter tile_size = ", tile_size,
                                 " must be a whole multiple of voxel_size = ", voxel_size, ", for example ",
                                 whole * voxel_size);
  require<std::invalid_argument>(whole <= VoxelSet::kMaxSide, "parameter tile_size = ", tile_size, " must be at most ",
                                 VoxelSet::kMaxSide, " times voxel_size = ", voxel_size);
}

struct Recorder::Impl {
  std::string directory;
  RecordParams params;
  RecordingInfo info;
  File lock;
  std::vector<RecordedCamera> cameras;
  std::vector<View> views;
  std::vector<Scan> scans;
  TableWriter views_table, scans_table;
  std::map<std::string, Eigen::Isometry3d> last_scans;  ///< pose of every sensor's last one
  std::optional<TileWriter> tiles;                      ///< from the moment the fields are known
  std::vector<PlacedPoint> placed;                      ///< kept between clouds, as fresh memory of this size is slow
  Clock::time_point last_flush = Clock::now();

  Impl(const std::string& dir, const std::string& map_frame, const RecordParams& record_params);
  void create(const std::string& map_frame);
  void resume(const std::string& map_frame);
  void fixOrigin(const Eigen::Vector3d& position);
  void fixFields(const std::vector<Field>& fields);
  const std::vector<PlacedPoint>& place(const Cloud& cloud, const Eigen::Isometry3d& map_from_sensor,
                                        InsertCounts& counts);
  void flush();
  void flushWhenDue();
  bool isInPlace() const;
  /// Throws where the recording's directory is gone: it is not made again.
  void makeFolder(const std::string& name) const { std::filesystem::create_directory(directory + '/' + name); }
};

Recorder::Impl::Impl(const std::string& dir, const std::string& map_frame, const RecordParams& record_params)
    : directory(dir),
      params(record_params),
      lock((params.check(), prepareDirectory(dir), lockRecording(dir))),
      views_table(TableWriter::ofViews(dir)),
      scans_table(TableWriter::ofScans(dir)) {
  if (hasRecording(directory)) {
    resume(map_frame);
  } else {
    create(map_frame);
  }
}

void Recorder::Impl::create(const std::string& map_frame) {
  info.map_frame = map_frame;
  info.voxel_size = params.voxel_size;
  info.tile_size = defaultTileSize(params);
  std::filesystem::create_directories(directory + "/tiles");
  writeInfo(directory, info);
}

void Recorder::Impl::resume(const std::string& map_frame) {
  const auto recording = Recording::open(directory);
  const auto& state = *recording.state_;
  info = state.info;
  require(info.map_frame == map_frame, "cannot continue the recording ", directory, ": its map frame is \"",
          info.map_frame, "\", not \"", map_frame, "\"; set map_frame, or record into another directory");
  require(info.voxel_size == params.voxel_size && info.tile_size == defaultTileSize(params),
          "cannot continue the recording ", directory, ": it was made with voxel_size = ", info.voxel_size,
          " and tile_size = ", info.tile_size, ", not ", params.voxel_size, " and ", defaultTileSize(params),
          "; set these, or record into another directory");
  cameras = state.cameras;
  views = state.views;
  scans = state.scans;
  std::filesystem::create_directories(directory + "/tiles");
  if (info.fields) tiles.emplace(directory, info, static_cast<std::size_t>(params.max_open_tiles), state.tiles);
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
  tiles.emplace(directory, info, static_cast<std::size_t>(params.max_open_tiles), std::vector<Tile>{});
}

/// Range gate in the sensor's frame, then the stored position and its tile.
const std::vector<PlacedPoint>& Recorder::Impl::place(const Cloud& cloud, const Eigen::Isometry3d& map_from_sensor,
                                                      InsertCounts& counts) {
  const TileGrid grid(info.voxel_size, info.tile_size);
  const double near_squared = params.min_range * params.min_range, far_squared = params.max_range * params.max_range;
  const Eigen::Matrix3d rotation = map_from_sensor.linear();
  Eigen::Vector3d translation = map_from_sensor.translation();
  if (info.origin) translation -= *info.origin;
  placed.clear();
  placed.reserve(static_cast<std::size_t>(cloud.positions.cols()));
  for (Eigen::Index i = 0; i < cloud.positions.cols(); ++i) {
    const Eigen::Vector3d in_sensor = cloud.positions.col(i);
    const double range_squared = in_sensor.squaredNorm();
    if (!(range_squared >= near_squared && range_squared <= far_squared)) {
      ++(!in_sensor.allFinite() ? counts.not_finite : range_squared < near_squared ? counts.too_near : counts.too_far);
      continue;
    }
    Eigen::Vector3d position = rotation * in_sensor + translation;
    if (!info.origin && position.allFinite()) {
      fixOrigin(position);
      translation -= *info.origin;
      position -= *info.origin;
    }
    if (!(position.cwiseAbs().maxCoeff() <= grid.limit())) {
      ++(in_sensor.allFinite() ? counts.too_far : counts.not_finite);
      continue;
    }
    PlacedPoint point;
    Eigen::Map<Eigen::Vector3f>(point.position.data()) = position.cast<float>();
    point.cell = grid.cellOf(point.position.data());
    point.source = static_cast<std::uint32_t>(i);
    placed.push_back(point);
  }
  return placed;
}

/// Whether `directory` is still the one that was locked.
bool Recorder::Impl::isInPlace() const {
  struct stat locked = {}, found = {};
  return ::fstat(lock.descriptor(), &locked) == 0 && ::stat(lock.path().c_str(), &found) == 0 &&
         locked.st_dev == found.st_dev && locked.st_ino == found.st_ino;
}

void Recorder::Impl::flush() {
  // Another recording may have taken the name; these points are not its own.
  require(!tiles || tiles->numPendingBytes() == 0 || isInPlace(), "the recording ", directory,
          " was deleted or moved away while points were recorded");
  if (tiles) tiles->flush();
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
    impl_->flush();
  } catch (const std::exception& error) {
    // A destructor cannot pass it on; whoever must know calls flush() before.
    std::fprintf(stderr, "the last points are lost: %s\n", error.what());
  }
}

std::uint32_t Recorder::setCamera(const std::string& name, const Intrinsics& intrinsics) {
  require<std::invalid_argument>(isFileName(name), "camera name \"", name,
                                 "\" must be made of letters, digits, _, - and .");
  const Camera checked(intrinsics);
  auto& cameras = impl_->cameras;
  std::string candidate = name;
  for (int variant = 2;; ++variant) {
    const auto found =
        std::find_if(cameras.begin(), cameras.end(), [&](const RecordedCamera& c) { return c.name == candidate; });
    if (found == cameras.end()) break;
    if (sameIntrinsics(found->intrinsics, intrinsics)) return static_cast<std::uint32_t>(found - cameras.begin());
    candidate = name + '_' + std::to_string(variant);
  }
  impl_->makeFolder("images");
  impl_->makeFolder("images/" + candidate);
  auto extended = cameras;
  extended.push_back({candidate, intrinsics, ""});
  writeCameras(impl_->directory, extended);
  cameras = std::move(extended);
  return static_cast<std::uint32_t>(cameras.size() - 1);
}

void Recorder::setMask(std::uint32_t camera, const cv::Mat1b& mask) {
  auto cameras = impl_->cameras;
  require<std::invalid_argument>(camera < cameras.size(), "there is no camera ", camera, " for this mask");
  auto& entry = cameras[camera];
  require<std::invalid_argument>(mask.cols == entry.intrinsics.width && mask.rows == entry.intrinsics.height,
                                 "the mask of ", entry.name, " is ", mask.cols, " x ", mask.rows,
                                 ", but its images are ", entry.intrinsics.width, " x ", entry.intrinsics.height);
  std::vector<std::uint8_t> png;
  cv::imencode(".png", mask, png);
  entry.mask = "masks/" + entry.name + ".png";
  impl_->makeFolder("masks");
  writeFileAtomically(impl_->directory + '/' + entry.mask, png.data(), png.size());
  writeCameras(impl_->directory, cameras);
  impl_->cameras = std::move(cameras);
}

Recorder::InsertCounts Recorder::addCloud(const Cloud& cloud, const Eigen::Isometry3d& map_from_sensor) {
  checkCloud(cloud);
  requirePose(map_from_sensor, "the pose of a cloud");
  impl_->flushWhenDue();  // after a failed flush this throws before more is held in memory
  InsertCounts counts;
  const auto& placed = impl_->place(cloud, map_from_sensor, counts);
  if (!placed.empty()) {
    impl_->fixFields(cloud.fields);
    const RecordMap record_map(cloud.fields, *impl_->info.fields);
    counts.fields_dropped = record_map.dropped();
    counts.fields_missing = record_map.missing();
    counts.added = impl_->tiles->insert(placed, cloud.records.data(), recordSize(cloud.fields), record_map);
    counts.voxel_taken = placed.size() - counts.added;
  }
  impl_->flushWhenDue();
  return counts;
}

std::size_t Recorder::addView(std::uint32_t camera, double stamp, const Eigen::Isometry3d& map_from_camera,
                              const std::vector<std::uint8_t>& encoded_image, const std::string& extension) {
  auto& impl = *impl_;
  require<std::invalid_argument>(camera < impl.cameras.size(), "there is no camera ", camera, " for this view");
  require<std::invalid_argument>(std::isfinite(stamp), "the stamp of a view must be finite, not ", stamp);
  require<std::invalid_argument>(isFileName(extension) && extension.size() <= 8, "image extension \"", extension,
                                 "\" must be a word such as jpg or png");
  require<std::invalid_argument>(!encoded_image.empty(), "the image of a view of ", impl.cameras[camera].name,
                                 " has no bytes");
  requirePose(map_from_camera, "the pose of a view");
  impl.fixOrigin(map_from_camera.translation());
  View view;
  view.camera = camera;
  view.stamp = stamp;
  view.map_from_camera = map_from_camera;
  view.map_from_camera.translation() -= *impl.info.origin;
  view.image = "images/" + impl.cameras[camera].name + '/' + sixDigits(impl.views.size()) + '.' + extension;
  writeFileAtomically(impl.directory + '/' + view.image, encoded_image.data(), encoded_image.size());
  impl.views_table.append(viewLine(view));
  impl.views.push_back(std::move(view));
  impl.flushWhenDue();
  return impl.views.size() - 1;
}

void Recorder::addScan(const std::string& sensor, double stamp, const Eigen::Matrix3Xd& positions,
                       const Eigen::Isometry3d& map_from_sensor) {
  auto& impl = *impl_;
  require<std::invalid_argument>(std::isfinite(stamp), "the stamp of a scan must be finite, not ", stamp);
  requirePose(map_from_sensor, "the pose of a scan");
  if (impl.params.scan_resolution == 0) return;
  const auto last = impl.last_scans.find(sensor);
  if (last != impl.last_scans.end()) {
    const Eigen::Isometry3d moved = last->second.inverse() * map_from_sensor;
    const double degrees = Eigen::AngleAxisd(moved.linear()).angle() * 180 / M_PI;
    if (moved.translation().norm() < kScanShare * impl.params.keyframe_distance &&
        degrees < kScanShare * impl.params.keyframe_angle) {
      return;
    }
  }
  impl.fixOrigin(map_from_sensor.translation());
  Scan scan{stamp, map_from_sensor, "scans/" + sixDigits(impl.scans.size()) + ".png"};
  scan.map_from_sensor.translation() -= *impl.info.origin;
  std::vector<std::uint8_t> png;
  cv::imencode(".png", makeRangePanorama(positions, impl.params.scan_resolution, impl.params.min_range), png,
               {cv::IMWRITE_PNG_COMPRESSION, 1});
  impl.makeFolder("scans");
  writeFileAtomically(impl.directory + '/' + scan.image, png.data(), png.size());
  impl.scans_table.append(scanLine(scan));
  impl.scans.push_back(std::move(scan));
  impl.last_scans[sensor] = map_from_sensor;
}

void Recorder::flush() {
  impl_->flush();
}

bool Recorder::isInPlace() const {
  return impl_->isInPlace();
}

Recording Recorder::snapshot() {
  impl_->flush();
  auto state = std::make_shared<Recording::State>();
  state->directory = impl_->directory;
  state->info = impl_->info;
  state->origin = impl_->info.origin.value_or(Eigen::Vector3d::Zero());
  state->fields = impl_->info.fields.value_or(std::vector<Field>{});
  state->cameras = impl_->cameras;
  state->views = impl_->views;
  state->scans = impl_->scans;
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
