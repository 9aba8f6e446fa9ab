// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause
#include "map/derived_files.hpp"

#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <filesystem>
#include <numeric>
#include <thread>

#include "base/parallel.hpp"
#include "base/text.hpp"
#include "cloud_colorizer/base/check.hpp"
#include "color/quantity.hpp"
#include "map/blob.hpp"
#include "recording/tile_file.hpp"

namespace cloud_colorizer {
namespace {

namespace fs = std::filesystem;

const std::string kCorrections = std::string(kAlignmentFolder) + '/' + kCorrectionsFile;
constexpr std::size_t kViewsPerBlock = 64;
constexpr std::size_t kSheenBytes = 3 * sizeof(float) + 1;
/// Bytes of a point's colour, count, deviation, reason, and what its nearest view shows.
constexpr std::size_t kColorBytes = 4 * sizeof(float) + sizeof(std::uint16_t) + 1 + 3 + 1;

}  // namespace

FolderLock::FolderLock(const std::string& directory, bool exclusive) {
  open(directory, exclusive);
  require(!file_ || file_->tryLock(exclusive), "another program is colouring or saving ", directory,
          "; wait for it, or work on a copy of the recording");
}

FolderLock::FolderLock(const std::string& directory, bool exclusive, const Callbacks& callbacks) {
  constexpr std::chrono::milliseconds kPause(20), kPatience(2000);
  open(directory, exclusive);
  auto silent = kPatience;
  while (file_ && !file_->tryLock(exclusive)) {
    throwIfCancelled(callbacks);
    if (silent.count() == 0 && callbacks.log) {
      callbacks.log(LogLevel::kInfo, "waiting for another program that works on " + directory);
    }
    silent -= kPause;
    std::this_thread::sleep_for(kPause);
  }
}

void FolderLock::open(const std::string& directory, bool exclusive) {
  const std::string path = directory + "/colorize.lock";
  if (!exclusive && fs::exists(path)) {
    file_.emplace(path, O_RDONLY);
  } else if (exclusive || ::access(directory.c_str(), W_OK) == 0) {
    file_.emplace(path, O_RDWR | O_CREAT);
  }
}

void DerivedFiles::claim(const std::string& folder, const std::string& key) const {
  if (holds(folder, key)) return removeAbandonedFiles(pathOf(folder));
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

std::string DerivedFiles::nameOfTile(std::size_t tile, const char* extension) const {
  return tileName(recording_.tiles()[tile].index) + extension;
}

std::vector<std::string> DerivedFiles::namesOfTiles(const std::vector<std::size_t>& tiles, const char* second) const {
  std::vector<std::string> names;
  for (const std::size_t tile : tiles) {
    for (const char* extension : {".bin", second}) names.push_back(nameOfTile(tile, extension));
  }
  return names;
}

std::string DerivedFiles::nameOfView(std::size_t view) {
  return sixDigits(view) + ".bin";
}

// The key does not tell how many points the tile had; the size of the file does.
bool DerivedFiles::hasMoving(std::size_t tile) const {
  return isWholeBlob(tileFile(kMovingFolder, tile), recording_.tiles()[tile].num_points);
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

std::size_t DerivedFiles::numQuantityFields() const {
  std::size_t count = 0;
  for (const Quantity& quantity : recording_.quantities()) count += fieldsOf(quantity).size();
  return count;
}

std::size_t DerivedFiles::bytesOfColor() const {
  return kColorBytes + numQuantityFields() * sizeof(float) + (with_sheen_ ? kSheenBytes : 0);
}

bool DerivedFiles::hasColors(std::size_t tile) const {
  return readWholeBlob(tileFile(kColorsFolder, tile, kViewsExtension)).has_value() &&
         isWholeBlob(tileFile(kColorsFolder, tile), bytesOfColor() * recording_.tiles()[tile].num_points);
}

void DerivedFiles::writeColors(std::size_t tile, const TileColors& colors, const TileViews& of_views) const {
  BlobWriter cells, blob;
  const auto count = static_cast<std::uint32_t>(of_views.tone.size());
  cells.add(&count, 1);
  for (const auto& [cell, sum] : of_views.tone) {
    const auto views = static_cast<std::uint32_t>(sum.views.size());
    cells.add(cell);
    cells.add(&sum.peak, 1);
    cells.add(&views, 1);
    for (const auto& [view, number] : sum.views) {
      cells.add(&view, 1);
      cells.add(&number, 1);
    }
  }
  const auto num_held_out = static_cast<std::uint32_t>(of_views.held_out.size());
  cells.add(&num_held_out, 1);
  cells.add(of_views.held_out);
  cells.save(tileFile(kColorsFolder, tile, kViewsExtension));
  blob.add(colors.values);
  blob.add(colors.count);
  blob.add(colors.stddev);
  blob.add(colors.unseen);
  blob.add(colors.nearest);
  blob.add(colors.camera);
  blob.add(colors.quantities);
  blob.add(colors.diffuse);
  blob.add(colors.specular);
  blob.save(tileFile(kColorsFolder, tile));
}

TileColors DerivedFiles::readColors(std::size_t tile) const {
  const std::size_t count = recording_.tiles()[tile].num_points;
  TileColors colors{Values(3, static_cast<Eigen::Index>(count)),
                    std::vector<std::uint16_t>(count),
                    std::vector<float>(count),
                    std::vector<Unseen>(count),
                    std::vector<std::array<std::uint8_t, 3>>(count),
                    std::vector<std::uint8_t>(count),
                    Eigen::Matrix3Xf(3, with_sheen_ ? static_cast<Eigen::Index>(count) : 0),
                    std::vector<std::uint8_t>(with_sheen_ ? count : 0),
                    Values(static_cast<Eigen::Index>(numQuantityFields()), static_cast<Eigen::Index>(count))};
  BlobReader blob(tileFile(kColorsFolder, tile));
  blob.read(colors.values);
  blob.read(colors.count);
  blob.read(colors.stddev);
  blob.read(colors.unseen);
  blob.read(colors.nearest);
  blob.read(colors.camera);
  blob.read(colors.quantities);
  blob.read(colors.diffuse);
  blob.read(colors.specular);
  return colors;
}

TileViews DerivedFiles::readViews(std::size_t tile) const {
  BlobReader blob(tileFile(kColorsFolder, tile, kViewsExtension));
  TileViews of_views;
  for (auto left = blob.read<std::uint32_t>(); left > 0; --left) {
    ToneCell cell{};
    blob.read(cell);
    ToneSum& sum = of_views.tone[cell];
    sum.peak = blob.read<double>();
    for (auto views = blob.read<std::uint32_t>(); views > 0; --views) {
      const auto view = blob.read<std::uint32_t>();
      sum.views[view] = blob.read<double>();
    }
  }
  of_views.held_out.resize(blob.read<std::uint32_t>());
  blob.read(of_views.held_out);
  return of_views;
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
  blob.save(pathOf(kCorrections));
}

std::optional<std::vector<CorrectedView>> DerivedFiles::readCorrections() const {
  auto bytes = readWholeBlob(pathOf(kCorrections));
  if (!bytes) return std::nullopt;
  BlobReader blob(pathOf(kCorrections), std::move(bytes));
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

std::size_t DerivedFiles::numViewBlocks() const {
  return (recording_.views().size() + kViewsPerBlock - 1) / kViewsPerBlock;
}

ViewList DerivedFiles::viewsOfBlock(std::size_t block) const {
  ViewList views(std::min(kViewsPerBlock, recording_.views().size() - block * kViewsPerBlock));
  std::iota(views.begin(), views.end(), static_cast<std::uint32_t>(block * kViewsPerBlock));
  return views;
}

void DerivedFiles::writeDamagedViews(std::size_t block, const ViewList& damaged) const {
  BlobWriter blob;
  blob.add(damaged);
  blob.save(pathOf(inFolder(kImageCheckFolder, block)));
}

std::optional<ViewList> DerivedFiles::readDamagedViews(std::size_t block) const {
  const std::string path = pathOf(inFolder(kImageCheckFolder, block));
  auto bytes = readWholeBlob(path);
  if (!bytes) return std::nullopt;
  ViewList damaged(bytes->size() / sizeof(damaged[0]));
  BlobReader(path, std::move(bytes)).read(damaged);
  return damaged;
}

}  // namespace cloud_colorizer
