// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause

/// The small files of a recording: recording.yaml, cameras.yaml, views.csv and scans.csv.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "base/file_io.hpp"
#include "cloud_colorizer/recording/recording.hpp"

namespace cloud_colorizer {

constexpr int kRecordingVersion = 1;

/// recording.yaml. The origin and the fields are known from the first cloud or view on.
struct RecordingInfo {
  std::string map_frame;
  double voxel_size = 0, tile_size = 0;
  std::optional<Eigen::Vector3d> origin;
  std::optional<std::vector<Field>> fields;
};

struct Recording::State {
  std::string directory;
  RecordingInfo info;
  Eigen::Vector3d origin = Eigen::Vector3d::Zero();
  std::vector<Field> fields;
  std::vector<RecordedCamera> cameras;
  std::vector<View> views;
  std::vector<Scan> scans;
  std::vector<Tile> tiles;
  std::size_t num_points = 0;
};

bool hasRecording(const std::string& directory);
RecordingInfo readInfo(const std::string& directory);
void writeInfo(const std::string& directory, const RecordingInfo& info);

std::vector<RecordedCamera> readCameras(const std::string& directory);
void writeCameras(const std::string& directory, const std::vector<RecordedCamera>& cameras);

/// A table that grows by lines. A last line without its end is what a crash left and is not counted.
template <class Row>
struct Table {
  std::vector<Row> rows;
  std::uint64_t num_bytes = 0;  ///< of whole lines
};
Table<View> readViews(const std::string& directory);
Table<Scan> readScans(const std::string& directory);

std::string viewLine(const View& view);
std::string scanLine(const Scan& scan);

/// Appends lines to a table; starts it with its header, or cuts off a line that a crash left torn.
class TableWriter {
 public:
  static TableWriter ofViews(const std::string& directory);
  static TableWriter ofScans(const std::string& directory);
  void append(const std::string& line);

 private:
  TableWriter(const std::string& path, const char* header, std::uint64_t num_bytes);

  File file_;
  std::uint64_t size_;
};

}  // namespace cloud_colorizer
