// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause

/// Reading and writing clouds: PLY and PCD, in blocks, so that memory is bounded whatever the size of the file.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "cloud_colorizer/base/types.hpp"
#include "cloud_colorizer/cloud/cloud.hpp"

namespace cloud_colorizer {

/// Reads .ply (ascii, binary little and big endian; other elements than vertex are skipped) and .pcd (ascii, binary,
/// binary_compressed; SIZE 8 allowed). Throws std::runtime_error, with file and reason, on anything else.
class CloudReader {
 public:
  explicit CloudReader(const std::string& path);
  ~CloudReader();
  std::size_t numPoints() const;
  const std::vector<Field>& fields() const;  ///< without x, y, z
  /// Up to `max_points` further points; empty at the end.
  Cloud read(std::size_t max_points);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

/// Writes a cloud of known size to `path` + a temporary suffix, and renames it on finish(): the file is complete or
/// absent. Positions are written as double where `double_positions`, else as float. The format follows the extension.
/// PCD: binary; a field "rgb" of type FLOAT32 holds packed colour. PLY: binary little endian; "rgb" is written as
/// uchar red, green, blue. The constructor throws std::runtime_error for an unknown extension or a missing directory,
/// write() and finish() when the disk is full; the temporary file is then removed.
class CloudWriter {
 public:
  CloudWriter(const std::string& path, std::size_t num_points, const std::vector<Field>& fields, bool double_positions);
  ~CloudWriter();
  void write(const Cloud& cloud);  ///< throws std::invalid_argument when the fields differ
  void finish();

  /// Throws std::runtime_error when `path` cannot be written: extension, directory. Call it before long work.
  static void checkPath(const std::string& path);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace cloud_colorizer
