// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause
#include "map/workspace.hpp"

#include <fcntl.h>
#include <sys/file.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iomanip>
#include <sstream>

#include "base/file_io.hpp"
#include "cloud_colorizer/base/check.hpp"
#include "cloud_colorizer/cloud/cloud_io.hpp"

namespace cloud_colorizer {
namespace {

namespace fs = std::filesystem;

constexpr double kMegabyte = 1e6;
/// Shares of memory_limit; the rest is for the chunks in work.
constexpr double kSurfaceShare = 0.08, kImageShare = 0.25, kDepthShare = 0.12, kScanShare = 0.02;

std::size_t bytesOf(const Surface& s) {
  return sizeof(float) *
         static_cast<std::size_t>(s.points.size() + s.surfels.normals.size() + 2 * s.surfels.radii.size());
}
std::size_t bytesOf(const cv::Mat& image) {
  return image.total() * image.elemSize();
}
std::size_t bytesOf(const DepthImage& image) {
  return bytesOf(image.depth) + bytesOf(image.edge) + (image.empty_space ? image.empty_space->numBytes() : 0);
}

std::size_t share(const Params& params, double fraction) {
  return static_cast<std::size_t>(params.colorize.memory_limit * kMegabyte * fraction);
}

/// Arrays one after the other in one file.
class BlobWriter {
 public:
  template <class T>
  void add(const T* data, std::size_t count) {
    const auto* bytes = reinterpret_cast<const char*>(data);
    blob_.insert(blob_.end(), bytes, bytes + count * sizeof(T));
  }
  /// Does not wait for the disk: what a power failure tears can be made again.
  void save(const std::string& path) const {
    AtomicFile file(path);
    file.append(blob_.data(), blob_.size());
    file.commit(false);
  }

 private:
  std::vector<char> blob_;
};

class BlobReader {
 public:
  explicit BlobReader(const std::string& path) : path_(path), file_(path, std::ios::binary) {}
  template <class T>
  void read(T* data, std::size_t count) {
    const auto bytes = static_cast<std::streamsize>(count * sizeof(T));
    require(static_cast<bool>(file_.read(reinterpret_cast<char*>(data), bytes)), "cannot read ", path_,
            "; delete its folder, it is derived data and will be made again");
  }

 private:
  std::string path_;
  std::ifstream file_;
};

/// Empties the folder unless its key.txt reads `key`.
void claimFolder(const fs::path& folder, const std::string& key) {
  std::ifstream file(folder / "key.txt");
  const std::string found{std::istreambuf_iterator<char>(file), {}};
  if (found == key) return;
  fs::remove_all(folder);
  fs::create_directories(folder);
  writeFileAtomically((folder / "key.txt").string(), key.data(), key.size());
}

/// Angle between the optical axis and the farthest corner [rad].
double coneAngle(const Camera& camera) {
  const auto& k = camera.intrinsics();
  double angle = 0;
  for (const double u : {-0.5, k.width - 0.5}) {
    for (const double v : {-0.5, k.height - 0.5}) {
      const auto bearing = camera.bearing({u, v});
      angle = std::max(angle, bearing ? std::acos(std::clamp(bearing->z(), -1.0, 1.0)) : camera.maxAngle());
    }
  }
  return angle;
}

}  // namespace

Workspace::Workspace(const Recording& recording, const Params& params)
    : recording_(recording),
      params_(params),
      scan_times_(recording.scans()),
      scans_(
          share(params, kScanShare), [this](std::size_t scan) { return emptyRanges(recording_.readScan(scan)); },
          [](const cv::Mat1w& ranges) { return bytesOf(ranges); }),
      surfaces_(
          share(params, kSurfaceShare), [this](std::size_t tile) { return readSurface(tile); },
          [](const Surface& surface) { return bytesOf(surface); }),
      images_(
          share(params, kImageShare), [this](std::size_t view) { return recording_.readImage(view); },
          [](const cv::Mat& image) { return bytesOf(image); }),
      depths_(
          share(params, kDepthShare), [this](std::size_t view) { return readDepth(view); },
          [](const DepthImage& image) { return bytesOf(image); }) {
  for (std::size_t i = 0; i < recording_.cameras().size(); ++i) {
    cameras_.emplace_back(recording_.cameras()[i].intrinsics);
    cone_angles_.push_back(coneAngle(cameras_.back()));
    cv::Mat mask = recording_.readMask(i);
    masks_.push_back(mask.empty() ? nullptr : std::make_shared<const cv::Mat>(std::move(mask)));
  }
  for (const View& view : recording_.views()) corrections_.push_back({view.map_from_camera, {}, 1});
}

FolderLock::FolderLock(const std::string& directory, bool exclusive)
    : file_(directory + "/colorize.lock", O_RDWR | O_CREAT) {
  require(::flock(file_.descriptor(), (exclusive ? LOCK_EX : LOCK_SH) | LOCK_NB) == 0,
          "another program is colouring or saving ", directory, "; wait for it, or work on a copy of the recording");
}

void Workspace::requireColors() const {
  std::ifstream file(recording_.directory() + "/colored/key.txt");
  const std::string found{std::istreambuf_iterator<char>(file), {}};
  require(found == colorsKeyOfAll(), "the colours in ", recording_.directory(),
          " were made with other parameters or from fewer points; colour it again first");
}

std::string Workspace::depthKeyOfAll() const {
  return surfelsKey(recording_, params_) + depthKey(recording_, params_) + posesKey(corrections_);
}

std::string Workspace::colorsKeyOfAll() const {
  return depthKeyOfAll() + colorsKey(recording_, params_) + exposuresKey(corrections_);
}

void Workspace::prepareAlignment() const {
  const fs::path base = recording_.directory();
  claimFolder(base / "surfels", surfelsKey(recording_, params_));
  // The other methods leave it for the next time.
  if (params_.colorize.method == Method::kDefault) claimFolder(base / "alignment", alignmentKey(recording_, params_));
}

void Workspace::prepareColors() const {
  const fs::path base = recording_.directory();
  claimFolder(base / "depth", depthKeyOfAll());
  claimFolder(base / "colored", colorsKeyOfAll());
}

// ---- files -------------------------------------------------------------------------------------------------------

std::string Workspace::tilePath(const char* folder, std::size_t tile) const {
  const TileIndex& index = recording_.tiles()[tile].index;
  std::ostringstream path;
  path << recording_.directory() << '/' << folder << '/' << index[0] << '_' << index[1] << '_' << index[2] << ".bin";
  return path.str();
}

std::string Workspace::depthPath(std::size_t view) const {
  std::ostringstream path;
  path << recording_.directory() << "/depth/" << std::setw(6) << std::setfill('0') << view << ".bin";
  return path.str();
}

bool Workspace::hasSurfels(std::size_t tile) const {
  std::error_code error;
  // The key does not tell how many points the tile had; the size of the file does.
  const std::uintmax_t size = 5 * sizeof(float) * recording_.tiles()[tile].num_points;
  return fs::file_size(tilePath("surfels", tile), error) == size && !error;
}

void Workspace::writeSurfels(std::size_t tile, const Surfels& surfels) const {
  BlobWriter blob;
  blob.add(surfels.normals.data(), static_cast<std::size_t>(surfels.normals.size()));
  blob.add(surfels.radii.data(), static_cast<std::size_t>(surfels.radii.size()));
  blob.add(surfels.offsets.data(), static_cast<std::size_t>(surfels.offsets.size()));
  blob.save(tilePath("surfels", tile));
}

Surface Workspace::readSurface(std::size_t tile) const {
  Surface surface;
  surface.points = recording_.readPoints(tile);
  surface.surfels.normals.resize(3, surface.points.cols());
  surface.surfels.radii.resize(surface.points.cols());
  surface.surfels.offsets.resize(surface.points.cols());
  BlobReader blob(tilePath("surfels", tile));
  blob.read(surface.surfels.normals.data(), static_cast<std::size_t>(surface.surfels.normals.size()));
  blob.read(surface.surfels.radii.data(), static_cast<std::size_t>(surface.surfels.radii.size()));
  blob.read(surface.surfels.offsets.data(), static_cast<std::size_t>(surface.surfels.offsets.size()));
  return surface;
}

bool Workspace::hasDepth(std::size_t view) const {
  return fs::exists(depthPath(view));
}

void Workspace::writeDepth(std::size_t view, const DepthImage& image) const {
  BlobWriter blob;
  const std::int32_t size[2] = {image.depth.rows, image.depth.cols};
  blob.add(size, 2);
  blob.add(&image.cell_size, 1);
  blob.add(&image.pixel_angle, 1);
  blob.add(image.depth.ptr<float>(), image.depth.total());
  blob.add(image.edge.ptr<std::uint8_t>(), image.edge.total());
  blob.save(depthPath(view));
}

DepthImage Workspace::readDepth(std::size_t view) {
  BlobReader blob(depthPath(view));
  std::int32_t size[2] = {0, 0};
  blob.read(size, 2);
  DepthImage image;
  blob.read(&image.cell_size, 1);
  blob.read(&image.pixel_angle, 1);
  image.depth.create(size[0], size[1]);
  image.edge.create(size[0], size[1]);
  blob.read(image.depth.ptr<float>(), image.depth.total());
  blob.read(image.edge.ptr<std::uint8_t>(), image.edge.total());
  image.empty_space = emptySpace(view, corrections_[view].map_from_camera);
  return image;
}

std::shared_ptr<const EmptySpace> Workspace::emptySpace(std::size_t view, const Eigen::Isometry3d& map_from_camera) {
  if (!params_.depth.use_scans) return nullptr;
  const double stamp = recording_.views()[view].stamp;
  return emptySpaceAt(recording_, scan_times_, stamp, map_from_camera,
                      [this](std::size_t scan) { return scans_.get(scan); });
}

bool Workspace::hasColors(std::size_t tile) const {
  return fs::exists(tilePath("colored", tile));
}

void Workspace::writeColors(std::size_t tile, const TileColors& colors) const {
  BlobWriter blob;
  const auto num_points = static_cast<std::size_t>(colors.values.cols());
  blob.add(colors.values.data(), 3 * num_points);
  blob.add(colors.count.data(), num_points);
  blob.add(colors.stddev.data(), num_points);
  blob.add(colors.unseen.data(), num_points);
  blob.save(tilePath("colored", tile));
}

TileColors Workspace::readColors(std::size_t tile) const {
  const std::size_t num_points = recording_.tiles()[tile].num_points;
  TileColors colors;
  colors.values.resize(3, static_cast<Eigen::Index>(num_points));
  colors.count.resize(num_points);
  colors.stddev.resize(num_points);
  colors.unseen.resize(num_points);
  BlobReader blob(tilePath("colored", tile));
  blob.read(colors.values.data(), 3 * num_points);
  blob.read(colors.count.data(), num_points);
  blob.read(colors.stddev.data(), num_points);
  blob.read(colors.unseen.data(), num_points);
  return colors;
}

// ---- corrections of the views -----------------------------------------------------------------------------------

void Workspace::correctViews(std::vector<CorrectedView> corrections) {
  corrections_ = std::move(corrections);
  BlobWriter blob;
  for (const CorrectedView& view : corrections_) {
    const Eigen::Matrix4d pose = view.map_from_camera.matrix();
    const std::int32_t sizes[2] = {static_cast<std::int32_t>(view.exposure.gain.size()),
                                   static_cast<std::int32_t>(view.exposure.offset.size())};
    blob.add(pose.data(), 16);
    blob.add(&view.weight, 1);
    blob.add(sizes, 2);
    blob.add(view.exposure.gain.data(), static_cast<std::size_t>(sizes[0]));
    blob.add(view.exposure.offset.data(), static_cast<std::size_t>(sizes[1]));
    blob.add(view.exposure.vignetting.data(), 2);
  }
  blob.save(recording_.directory() + "/alignment/views.bin");
}

bool Workspace::restoreCorrections() {
  if (params_.colorize.method != Method::kDefault) return false;
  const std::string path = recording_.directory() + "/alignment/views.bin";
  if (!fs::exists(path)) return false;
  BlobReader blob(path);
  for (CorrectedView& view : corrections_) {
    Eigen::Matrix4d pose;
    std::int32_t sizes[2] = {0, 0};
    blob.read(pose.data(), 16);
    blob.read(&view.weight, 1);
    blob.read(sizes, 2);
    view.map_from_camera.matrix() = pose;
    view.exposure.gain.resize(sizes[0]);
    view.exposure.offset.resize(sizes[1]);
    blob.read(view.exposure.gain.data(), static_cast<std::size_t>(sizes[0]));
    blob.read(view.exposure.offset.data(), static_cast<std::size_t>(sizes[1]));
    blob.read(view.exposure.vignetting.data(), 2);
  }
  return true;
}

// ---- views -------------------------------------------------------------------------------------------------------

ObservedView Workspace::observedView(std::size_t view) {
  const std::uint32_t camera = recording_.views()[view].camera;
  ObservedView observed;
  observed.id = static_cast<std::uint32_t>(view);
  observed.camera = &cameras_[camera];
  observed.map_from_camera = corrections_[view].map_from_camera;
  observed.exposure = corrections_[view].exposure;
  observed.weight = corrections_[view].weight;
  observed.image = images_.get(view);
  observed.mask = masks_[camera];
  observed.depth = depths_.get(view);
  return observed;
}

std::vector<std::size_t> Workspace::viewsOf(const Eigen::AlignedBox3f& box) const {
  std::vector<std::size_t> views;
  for (std::size_t view = 0; view < recording_.views().size(); ++view) {
    if (mayObserve(view, box)) views.push_back(view);
  }
  return views;
}

bool Workspace::mayObserve(std::size_t view, const Eigen::AlignedBox3f& box) const {
  const double radius = 0.5 * box.diagonal().cast<double>().norm();
  const Eigen::Vector3d center = corrections_[view].map_from_camera.inverse() * box.center().cast<double>();
  const double distance = center.norm();
  if (distance <= radius) return true;
  if (distance - radius > params_.depth.max_view_distance) return false;
  const double angle = std::acos(std::clamp(center.z() / distance, -1.0, 1.0));
  return angle - std::asin(radius / distance) < cone_angles_[recording_.views()[view].camera];
}

}  // namespace cloud_colorizer
