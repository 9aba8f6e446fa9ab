// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause

/// The small files of a recording that are written whole: recording.yaml and cameras.yaml.
#pragma once

#include <cstdint>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "cloud_colorizer/recording/recorder.hpp"
#include "cloud_colorizer/recording/recording.hpp"

namespace cloud_colorizer {

constexpr int kRecordingVersion = 1;

/// recording.yaml. The origin and the fields are known from the first cloud or view on.
struct RecordingInfo {
  std::string map_frame;
  double voxel_size = 0, tile_size = 0;
  double max_range = std::numeric_limits<double>::infinity();  ///< m
  std::optional<Eigen::Vector3d> origin;
  std::optional<std::vector<Field>> fields;
  std::string crs;
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
double defaultTileSize(const RecordParams& params);  ///< m
/// Writes that of a new recording. Before any other file, since a directory without it is somebody else's.
RecordingInfo newInfo(const std::string& directory, const std::string& map_frame, const RecordParams& params);

std::vector<RecordedCamera> readCameras(const std::string& directory);
void writeCameras(const std::string& directory, const std::vector<RecordedCamera>& cameras);

bool isFileName(const std::string& name);
/// Throws where the recording itself is gone: it is not made again.
void makeFolder(const std::string& directory, const std::string& name);

}  // namespace cloud_colorizer
