// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause
#include "map/derived_files.hpp"

#include <fcntl.h>
#include <unistd.h>
#include <zlib.h>

#include <cstring>
#include <filesystem>

#include "base/text.hpp"
#include "cloud_colorizer/base/check.hpp"
#include "recording/tile_file.hpp"

namespace cloud_colorizer {
namespace {

namespace fs = std::filesystem;

const std::string kViews = "/views.bin";
constexpr const char* kTone = ".tone";
/// Bytes of a point's normal, radius, offset and thickness; of its colour, count, deviation and reason.
constexpr std::size_t kSurfelBytes = 6 * sizeof(float), kColorBytes = 4 * sizeof(float) + sizeof(std::uint16_t) + 1;

using Checksum = std::uint32_t;

/// Before the cells of a depth image.
struct DepthHead {
  std::int32_t rows, cols;
  float cell_size, pixel_angle;
};

Checksum checksum(const std::uint8_t* bytes, std::size_t size) {
  return static_cast<Checksum>(crc32_z(0, bytes, size));
}

/// The content of a file without its checksum; nothing where the file is not there or not what was written.
std::optional<std::vector<std::uint8_t>> readWhole(const std::string& path) {
  if (!fs::exists(path)) return std::nullopt;
  std::vector<std::uint8_t> bytes = readFile(path);
  if (bytes.size() < sizeof(Checksum)) return std::nullopt;
  Checksum found = 0;
  const std::size_t size = bytes.size() - sizeof(found);
  std::memcpy(&found, bytes.data() + size, sizeof(found));
  if (found != checksum(bytes.data(), size)) return std::nullopt;
  bytes.resize(size);
  return bytes;
}

bool isWhole(const std::string& path, std::size_t size) {
  std::error_code error;
  if (fs::file_size(path, error) != size + sizeof(Checksum) || error) return false;
  return readWhole(path).has_value();
}

/// Arrays one after the other in one file.
class BlobWriter {
 public:
  template <class T>
  void add(const T* data, std::size_t count) {
    const auto* bytes = reinterpret_cast<const std::uint8_t*>(data);
    blob_.insert(blob_.end(), bytes, bytes + count * sizeof(T));
  }
  template <class Matrix>
  void add(const Matrix& matrix) {
    add(matrix.data(), static_cast<std::size_t>(matrix.size()));
  }
  /// Does not wait for the disk: what a power failure tears can be made again.
  void save(const std::string& path) {
    const Checksum sum = checksum(blob_.data(), blob_.size());
    add(&sum, 1);
    writeFileAtomically(path, blob_.data(), blob_.size());
  }

 private:
  std::vector<std::uint8_t> blob_;
};

class BlobReader {
 public:
  explicit BlobReader(const std::string& path) : BlobReader(path, readWhole(path)) {}
  BlobReader(std::string path, std::optional<std::vector<std::uint8_t>> blob) : path_(std::move(path)) {
    requireWhole(blob.has_value());
    blob_ = *std::move(blob);
  }
  template <class T>
  void read(T* data, std::size_t count) {
    requireWhole(count <= (blob_.size() - next_) / sizeof(T));
    if (count > 0) std::memcpy(data, blob_.data() + next_, count * sizeof(T));
    next_ += count * sizeof(T);
  }
  template <class Matrix>
  void read(Matrix& matrix) {
    read(matrix.data(), static_cast<std::size_t>(matrix.size()));
  }
  template <class T>
  T read() {
    T value{};
    read(&value, 1);
    return value;
  }

 private:
  void requireWhole(bool whole) const {
    require(whole, "cannot use ", path_,
            ": it is missing or damaged; colour the recording again, it will be made anew");
  }

  std::string path_;
  std::vector<std::uint8_t> blob_;
  std::size_t next_ = 0;
};

}  // namespace

FolderLock::FolderLock(const std::string& directory, bool exclusive) {
  const std::string path = directory + "/colorize.lock";
  if (!exclusive && fs::exists(path)) {
    file_.emplace(path, O_RDONLY);
  } else if (exclusive || ::access(directory.c_str(), W_OK) == 0) {
    file_.emplace(path, O_RDWR | O_CREAT);
  }
  require(!file_ || file_->tryLock(exclusive), "another program is colouring or saving ", directory,
          "; wait for it, or work on a copy of the recording");
}

void DerivedFiles::claim(const std::string& folder, const std::string& key) const {
  if (holds(folder, key)) return;
  fs::remove_all(pathOf(folder));
  fs::create_directories(pathOf(folder));
  writeFileAtomically(pathOf(folder + "/key.txt"), key.data(), key.size());
}

bool DerivedFiles::holds(const std::string& folder, const std::string& key) const {
  const std::string path = pathOf(folder + "/key.txt");
  if (!fs::exists(path)) return false;
  const auto found = readFile(path);
  return std::string(found.begin(), found.end()) == key;
}

std::string DerivedFiles::tileFile(const char* folder, std::size_t tile, const char* extension) const {
  return pathOf(std::string(folder) + '/' + tileName(recording_.tiles()[tile].index) + extension);
}

std::string DerivedFiles::depthFile(std::size_t view) const {
  return pathOf(std::string(kDepthFolder) + '/' + sixDigits(view) + ".bin");
}

// The key does not tell how many points the tile had; the size of the file does.
bool DerivedFiles::hasMoving(std::size_t tile) const {
  return isWhole(tileFile(kMovingFolder, tile), recording_.tiles()[tile].num_points);
}

void DerivedFiles::writeMoving(std::size_t tile, const std::vector<std::uint8_t>& shares) const {
  BlobWriter blob;
  blob.add(shares);
  blob.save(tileFile(kMovingFolder, tile));
}

std::vector<std::uint8_t> DerivedFiles::readMoving(std::size_t tile) const {
  std::vector<std::uint8_t> shares(recording_.tiles()[tile].num_points);
  BlobReader(tileFile(kMovingFolder, tile)).read(shares);
  return shares;
}

bool DerivedFiles::hasSurfels(std::size_t tile) const {
  return isWhole(tileFile(kSurfelsFolder, tile), kSurfelBytes * recording_.tiles()[tile].num_points);
}

void DerivedFiles::writeSurfels(std::size_t tile, const Surfels& surfels) const {
  BlobWriter blob;
  blob.add(surfels.normals);
  blob.add(surfels.radii);
  blob.add(surfels.offsets);
  blob.add(surfels.thicknesses);
  blob.save(tileFile(kSurfelsFolder, tile));
}

Surfels DerivedFiles::readSurfels(std::size_t tile) const {
  const auto num_points = static_cast<Eigen::Index>(recording_.tiles()[tile].num_points);
  Surfels surfels{Eigen::Matrix3Xf(3, num_points), Eigen::VectorXf(num_points), Eigen::VectorXf(num_points),
                  Eigen::VectorXf(num_points)};
  BlobReader blob(tileFile(kSurfelsFolder, tile));
  blob.read(surfels.normals);
  blob.read(surfels.radii);
  blob.read(surfels.offsets);
  blob.read(surfels.thicknesses);
  return surfels;
}

bool DerivedFiles::hasDepth(std::size_t view) const {
  return readWhole(depthFile(view)).has_value();
}

void DerivedFiles::writeDepth(std::size_t view, const DepthImage& image) const {
  BlobWriter blob;
  const DepthHead head = {image.depth.rows, image.depth.cols, image.cell_size, image.pixel_angle};
  blob.add(&head, 1);
  blob.add(image.depth.ptr<float>(), image.depth.total());
  blob.add(image.edge.ptr<std::uint8_t>(), image.edge.total());
  blob.save(depthFile(view));
}

DepthImage DerivedFiles::readDepth(std::size_t view) const {
  const std::string path = depthFile(view);
  DepthHead head{};
  File(path, O_RDONLY).readAt(0, &head, sizeof(head));
  const std::size_t cells = static_cast<std::size_t>(head.rows) * static_cast<std::size_t>(head.cols);
  const auto file = std::make_shared<const MappedFile>(path, sizeof(head) + cells * (sizeof(float) + 1));
  // Nobody writes to an image that was read.
  auto* const bytes = const_cast<std::uint8_t*>(file->data()) + sizeof(head);
  DepthImage image;
  image.cell_size = head.cell_size;
  image.pixel_angle = head.pixel_angle;
  image.depth = cv::Mat1f(head.rows, head.cols, reinterpret_cast<float*>(bytes));
  image.edge = cv::Mat1b(head.rows, head.cols, bytes + cells * sizeof(float));
  image.owner = file;
  return image;
}

bool DerivedFiles::hasColors(std::size_t tile) const {
  return readWhole(tileFile(kColorsFolder, tile, kTone)).has_value() &&
         isWhole(tileFile(kColorsFolder, tile), kColorBytes * recording_.tiles()[tile].num_points);
}

void DerivedFiles::writeColors(std::size_t tile, const TileColors& colors, const ToneCells& tone) const {
  BlobWriter cells, blob;
  const auto count = static_cast<std::uint32_t>(tone.size());
  cells.add(&count, 1);
  for (const auto& [cell, sum] : tone) {
    const auto views = static_cast<std::uint32_t>(sum.views.size());
    cells.add(cell);
    cells.add(&sum.peak, 1);
    cells.add(&views, 1);
    for (const auto& [view, number] : sum.views) {
      cells.add(&view, 1);
      cells.add(&number, 1);
    }
  }
  cells.save(tileFile(kColorsFolder, tile, kTone));
  blob.add(colors.values);
  blob.add(colors.count);
  blob.add(colors.stddev);
  blob.add(colors.unseen);
  blob.save(tileFile(kColorsFolder, tile));
}

TileColors DerivedFiles::readColors(std::size_t tile) const {
  const std::size_t count = recording_.tiles()[tile].num_points;
  TileColors colors{Values(3, static_cast<Eigen::Index>(count)), std::vector<std::uint16_t>(count),
                    std::vector<float>(count), std::vector<Unseen>(count)};
  BlobReader blob(tileFile(kColorsFolder, tile));
  blob.read(colors.values);
  blob.read(colors.count);
  blob.read(colors.stddev);
  blob.read(colors.unseen);
  return colors;
}

ToneCells DerivedFiles::readTone(std::size_t tile) const {
  BlobReader blob(tileFile(kColorsFolder, tile, kTone));
  ToneCells cells;
  for (auto left = blob.read<std::uint32_t>(); left > 0; --left) {
    ToneCell cell{};
    blob.read(cell);
    ToneSum& sum = cells[cell];
    sum.peak = blob.read<double>();
    for (auto views = blob.read<std::uint32_t>(); views > 0; --views) {
      const auto view = blob.read<std::uint32_t>();
      sum.views[view] = blob.read<double>();
    }
  }
  return cells;
}

void DerivedFiles::writeCorrections(const std::vector<CorrectedView>& views) const {
  BlobWriter blob;
  for (const CorrectedView& view : views) {
    const std::int32_t channels[2] = {static_cast<std::int32_t>(view.exposure.gain.size()),
                                      static_cast<std::int32_t>(view.exposure.offset.size())};
    blob.add(view.map_from_camera.matrix());
    blob.add(&view.weight, 1);
    blob.add(channels, 2);
    blob.add(view.exposure.gain);
    blob.add(view.exposure.offset);
    blob.add(view.exposure.vignetting);
  }
  blob.save(pathOf(kAlignmentFolder + kViews));
}

std::optional<std::vector<CorrectedView>> DerivedFiles::readCorrections() const {
  auto bytes = readWhole(pathOf(kAlignmentFolder + kViews));
  if (!bytes) return std::nullopt;
  BlobReader blob(pathOf(kAlignmentFolder + kViews), std::move(bytes));
  std::vector<CorrectedView> views(recording_.views().size());
  for (CorrectedView& view : views) {
    blob.read(view.map_from_camera.matrix());
    view.weight = blob.read<float>();
    view.exposure.gain.resize(blob.read<std::int32_t>());
    view.exposure.offset.resize(blob.read<std::int32_t>());
    blob.read(view.exposure.gain);
    blob.read(view.exposure.offset);
    blob.read(view.exposure.vignetting);
  }
  return views;
}

void DerivedFiles::writeDamagedViews(const ViewList& views) const {
  BlobWriter blob;
  blob.add(views);
  blob.save(pathOf(kImageCheckFolder + kViews));
}

std::optional<ViewList> DerivedFiles::readDamagedViews() const {
  auto bytes = readWhole(pathOf(kImageCheckFolder + kViews));
  if (!bytes) return std::nullopt;
  ViewList views(bytes->size() / sizeof(views[0]));
  BlobReader(pathOf(kImageCheckFolder + kViews), std::move(bytes)).read(views);
  return views;
}

}  // namespace cloud_colorizer
