// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause

/// The tables of a recording: views.csv, readouts.csv, scans.csv and clouds.csv.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "base/file_io.hpp"
#include "cloud_colorizer/recording/recording.hpp"

namespace cloud_colorizer {

/// A table that grows by lines. A last line without its end is what a crash left and is not counted.
template <class Row>
struct Table {
  std::vector<Row> rows;
  std::uint64_t num_bytes = 0;  ///< of whole lines
};
Table<View> readViews(const std::string& directory);
bool hasReadouts(const std::string& directory);
Table<Scan> readScans(const std::string& directory);
Table<std::string> readClouds(const std::string& directory);  ///< lines

/// A pose as it is read from the tables again, which keep a rotation as a quaternion.
Eigen::Isometry3d poseInTable(const Eigen::Isometry3d& pose);
std::string viewLine(const View& view);
std::string readoutLine(std::size_t view, const Twist& motion);
std::string scanLine(const Scan& scan);

/// Appends lines to a table; starts it with its header, or cuts off a line that a crash left torn.
class TableWriter {
 public:
  static TableWriter ofViews(const std::string& directory);
  static TableWriter ofReadouts(const std::string& directory);
  static TableWriter ofScans(const std::string& directory);
  static TableWriter ofClouds(const std::string& directory);
  /// All of the lines, or none when it throws.
  void append(const std::string& lines);

 private:
  TableWriter(const std::string& path, const char* header, std::uint64_t num_bytes);

  File file_;
  std::uint64_t size_;
};

}  // namespace cloud_colorizer
