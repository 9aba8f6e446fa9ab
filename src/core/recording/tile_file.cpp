// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause
#include "recording/tile_file.hpp"

#include <fcntl.h>

#include <algorithm>
#include <cstring>
#include <filesystem>
#include <limits>

#include "base/file_io.hpp"
#include "base/text.hpp"
#include "cloud/pcd.hpp"
#include "cloud_colorizer/base/check.hpp"

namespace cloud_colorizer {

namespace {

/// False for names that are not tiles, such as those of temporary files.
bool tileIndexFromName(const std::string& stem, TileIndex& index) {
  const auto parts = splitAt(stem, '_');
  if (parts.size() != 3) return false;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    long long value = 0;
    if (!parseInteger(parts[axis], value) || value < std::numeric_limits<std::int32_t>::min() ||
        value > std::numeric_limits<std::int32_t>::max()) {
      return false;
    }
    index[axis] = static_cast<std::int32_t>(value);
  }
  return true;
}

/// The count that the header promises. Another process may be writing it at this moment, then it is read again.
std::uint64_t readHeaderCount(const File& file, const std::vector<Field>& fields) {
  std::string header = pcdHeader(fields, false, 0);
  const auto position = header.find("WIDTH ") + 6;
  const std::size_t num_digits = 10;
  for (int attempt = 0; attempt < 100; ++attempt) {
    file.readAt(0, header.data(), header.size());
    long long count = 0;
    if (parseInteger(header.substr(position, num_digits), count) && count >= 0 &&
        header == pcdHeader(fields, false, static_cast<std::uint64_t>(count))) {
      return static_cast<std::uint64_t>(count);
    }
  }
  throw std::runtime_error("tile " + file.path() +
                           " is damaged: its header does not fit the fields in recording.yaml; move it away to go on "
                           "without its points");
}

std::uint64_t countRecords(const File& file, const std::vector<Field>& fields) {
  const auto header_size = pcdHeader(fields, false, 0).size(), size = file.size();
  return size < header_size ? 0 : (size - header_size) / (kPositionSize + recordSize(fields));
}

/// Points that can be read: none while the header is not complete, and no more than there are bytes.
std::uint64_t countPoints(const File& file, const std::vector<Field>& fields) {
  const std::uint64_t num_records = countRecords(file, fields);
  return num_records == 0 ? 0 : std::min(readHeaderCount(file, fields), num_records);
}

}  // namespace

std::string tileName(const TileIndex& index) {
  return std::to_string(index[0]) + '_' + std::to_string(index[1]) + '_' + std::to_string(index[2]);
}

std::string tilePath(const std::string& directory, const TileIndex& index) {
  return directory + "/tiles/" + tileName(index) + ".pcd";
}

std::vector<Tile> listTiles(const std::string& directory, const std::vector<Field>& fields) {
  std::vector<Tile> tiles;
  const std::filesystem::path folder = directory + "/tiles";
  if (!std::filesystem::is_directory(folder)) return tiles;
  for (const auto& entry : std::filesystem::directory_iterator(folder)) {
    Tile tile;
    if (entry.path().extension() != ".pcd" || !tileIndexFromName(entry.path().stem().string(), tile.index)) continue;
    tile.num_points = countPoints(File(entry.path().string(), O_RDONLY), fields);
    if (tile.num_points > 0) tiles.push_back(tile);
  }
  std::sort(tiles.begin(), tiles.end(), [](const Tile& a, const Tile& b) { return a.index < b.index; });
  return tiles;
}

std::vector<std::uint8_t> readTileColumns(const std::string& directory, const Tile& tile,
                                          const std::vector<Field>& fields, std::size_t begin, std::size_t size) {
  std::vector<std::uint8_t> columns(tile.num_points * size);
  if (columns.empty()) return columns;
  const File file(tilePath(directory, tile.index), O_RDONLY);
  const auto record_size = kPositionSize + recordSize(fields);
  const auto header_size = pcdHeader(fields, false, 0).size();
  const std::size_t block_points = std::max<std::size_t>(1, (std::size_t{1} << 18) / record_size);
  std::vector<std::uint8_t> block(std::min(block_points, tile.num_points) * record_size);
  auto* target = columns.data();
  for (std::size_t first = 0; first < tile.num_points; first += block_points) {
    const auto num_points = std::min(block_points, tile.num_points - first);
    file.readAt(header_size + first * record_size, block.data(), num_points * record_size);
    for (std::size_t i = 0; i < num_points; ++i, target += size) {
      std::memcpy(target, block.data() + i * record_size + begin, size);
    }
  }
  return columns;
}

std::uint64_t countTileRecords(const std::string& directory, const TileIndex& index, const std::vector<Field>& fields) {
  const std::string path = tilePath(directory, index);
  return std::filesystem::exists(path) ? countRecords(File(path, O_RDONLY), fields) : 0;
}

std::uint64_t appendToTile(const std::string& directory, const TileIndex& index, const std::vector<Field>& fields,
                           std::uint64_t num_points, const std::vector<std::uint8_t>& records) {
  const auto record_size = kPositionSize + recordSize(fields);
  const auto added = records.size() / record_size;
  File file(tilePath(directory, index), O_RDWR | O_CREAT);
  // Writing behind the end of a file that was cut would fill the gap with zeros: points that nobody measured.
  num_points = std::min(num_points, countRecords(file, fields));
  const auto header = pcdHeader(fields, false, num_points);
  const auto end = header.size() + num_points * record_size;
  if (file.size() > end) file.truncate(end);
  if (num_points == 0) file.writeAt(0, header.data(), header.size());
  file.writeAt(end, records.data(), records.size());
  const auto new_header = pcdHeader(fields, false, num_points + added);
  file.writeAt(0, new_header.data(), new_header.size());
  file.close();
  return num_points + added;
}

void cutTile(const std::string& directory, const TileIndex& index, const std::vector<Field>& fields,
             std::uint64_t num_points) {
  const std::string path = tilePath(directory, index);
  if (num_points == 0) std::filesystem::remove(path);
  if (!std::filesystem::exists(path)) return;
  File file(path, O_RDWR);
  const auto header = pcdHeader(fields, false, num_points);
  const auto end = header.size() + num_points * (kPositionSize + recordSize(fields));
  if (file.size() < end) return;
  file.writeAt(0, header.data(), header.size());
  file.truncate(end);
}

}  // namespace cloud_colorizer
