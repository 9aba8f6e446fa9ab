// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause
#include "recording/cloud_log.hpp"

#include <fcntl.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <sstream>

#include "base/text.hpp"
#include "cloud_colorizer/base/check.hpp"
#include "recording/tile_file.hpp"

namespace cloud_colorizer {
namespace {

std::string undoPath(const std::string& directory) {
  return directory + "/tiles.undo";
}

/// Frame names may hold anything.
std::string lineOf(const CloudSource& source) {
  require<std::invalid_argument>(std::isfinite(source.stamp), "the stamp of a cloud must be finite, not ",
                                 source.stamp);
  std::string sensor = source.sensor;
  std::replace_if(
      sensor.begin(), sensor.end(), [](unsigned char c) { return c < ' '; }, '_');
  return formatFixed(source.stamp, 9) + ',' + sensor;
}

}  // namespace

void undoTiles(const std::string& directory, const std::vector<Field>& fields) {
  if (!std::filesystem::exists(undoPath(directory))) return;
  const auto bytes = readFile(undoPath(directory));
  std::istringstream text(std::string(bytes.begin(), bytes.end()));
  std::uint64_t num_bytes = 0;
  // When clouds.csv grew after these notes, their points belong to whole clouds.
  if (!(text >> num_bytes) || num_bytes != readClouds(directory).num_bytes) return;
  TileIndex tile{};
  std::uint64_t num_points = 0;
  std::string end;  // a note without it was torn, and its tile did not grow
  while (text >> tile[0] >> tile[1] >> tile[2] >> num_points >> end && end == ";") {
    cutTile(directory, tile, fields, num_points);
  }
}

CloudLog::CloudLog(const std::string& directory, bool with_undo) : table_(TableWriter::ofClouds(directory)) {
  const Table<std::string> clouds = readClouds(directory);
  earlier_.insert(clouds.rows.begin(), clouds.rows.end());
  num_bytes_ = clouds.num_bytes;
  if (!with_undo) return;
  undo_.emplace(undoPath(directory), O_WRONLY | O_CREAT);
  undo_->truncate(0);
}

bool CloudLog::recognize(const CloudSource& source) {
  const auto found = earlier_.find(lineOf(source));
  if (found == earlier_.end()) return false;
  earlier_.erase(found);
  return true;
}

void CloudLog::add(const CloudSource& source) {
  waiting_ += lineOf(source) + '\n';
}

void CloudLog::noteGrowth(const TileIndex& tile, std::uint64_t num_points) {
  if (!undo_ || noted_.count(tile) > 0) return;
  std::ostringstream note;
  if (undo_size_ == 0) note << num_bytes_ << '\n';
  note << tile[0] << ' ' << tile[1] << ' ' << tile[2] << ' ' << num_points << " ;\n";
  undo_->writeAt(undo_size_, note.str().data(), note.str().size());
  undo_size_ += note.str().size();
  noted_.insert(tile);
}

void CloudLog::commit() {
  if (!waiting_.empty()) table_.append(waiting_);
  num_bytes_ += waiting_.size();
  waiting_.clear();
  if (undo_size_ == 0) return;
  undo_->truncate(0);
  undo_size_ = 0;
  noted_.clear();
}

}  // namespace cloud_colorizer
