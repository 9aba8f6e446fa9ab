// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause

/// Reading and writing clouds: PLY and PCD, in blocks, so that memory is bounded whatever the size of the file.
#pragma once

#include <Eigen/Geometry>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "cloud_colorizer/base/types.hpp"
#include "cloud_colorizer/cloud/cloud.hpp"

namespace cloud_colorizer {

/// "map.pcd" -> "map.origin.txt": x, y, z that the points of the PCD are relative to.
std::string originFile(const std::string& pcd);

/// Reads .ply (ascii, binary little and big endian; other elements than vertex and lists within it are skipped) and
/// .pcd (ascii, binary, binary_compressed; VIEWPOINT and an originFile() beside it are applied). X, Y, Z are x, y, z.
/// 64 bit integers become float64. .las of any point format, not compressed. Limits: a line of text of 1 MiB, a point
/// of a million numbers, and 4 GB of points in a compressed file, all of which are then held in memory.
class CloudReader {
 public:
  /// Reads the header. Throws std::runtime_error, with file and reason, when it is damaged or of another format, or
  /// announces more than the file can hold; no memory is taken before that is known.
  explicit CloudReader(const std::string& path);
  ~CloudReader();
  std::size_t numPoints() const;
  const std::vector<Field>& fields() const;  ///< without x, y, z
  /// Coordinate reference system of a LAS: well-known text or "EPSG:25832"; empty: unknown.
  const std::string& crs() const;
  /// Up to `max_points` further points, in the order and frame of the file; empty at the end. Throws
  /// std::runtime_error, with file and place, on a line that is no point.
  Cloud read(std::size_t max_points);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

/// Writes a cloud of known size to `path` + a temporary suffix, and renames it on finish(): the file is complete or
/// absent. Positions are written as double where `double_positions`, else as float. The format follows the extension.
/// LAS: integers in a `box`, which must hold all points; "rgb" becomes its colours of 16 bits, what it has no place for
/// extra bytes; `crs`, its coordinate reference system, is well-known text or a code such as EPSG:25832. PCD: binary,
/// fields as they are. PLY: binary little endian; "rgb" becomes uchar red, green, blue, and an array name_0, name_1,
/// ... The constructor throws std::runtime_error for an unknown extension or a missing directory and
/// std::invalid_argument for fields that checkFields refuses; write() and finish() throw std::runtime_error when the
/// disk is full. The temporary file is removed unless finish() came to its end.
class CloudWriter {
 public:
  CloudWriter(const std::string& path, std::size_t num_points, const std::vector<Field>& fields, bool double_positions,
              const Eigen::AlignedBox3d& box = {}, const std::string& crs = "");
  ~CloudWriter();
  /// Further points. Throws std::invalid_argument when the fields differ or there are more than `num_points`.
  void write(const Cloud& cloud);
  void finish();  ///< throws std::invalid_argument when points are missing

  /// Throws std::runtime_error when `path` cannot be written: extension, directory. Call it before long work.
  static void checkPath(const std::string& path);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace cloud_colorizer
