// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause

/// LAS files: the header of any version from 1.0 to 1.4 that is not compressed, and the 1.4 that we write.
/// "LAS Specification 1.4 - R15", ASPRS, 2019.
#pragma once

#include <Eigen/Geometry>
#include <cstdint>
#include <string>
#include <vector>

#include "cloud/block_reader.hpp"
#include "cloud/cloud_layout.hpp"

namespace cloud_colorizer {

/// "; convert it: ..." with the commands that make a .las of a .laz.
std::string remedyOfLaz(const std::string& path);

/// Reads the header; the reader then stands at the first point. Fields: intensity, classification, scan_angle,
/// user_data, point_source_id, gps_time, red, green, blue (16 bits), nir, and the extra bytes under their names;
/// numbers and flags of returns are left out. Throws std::runtime_error with file, reason and remedy.
CloudHeader readLasHeader(BlockReader& input);

/// How points become LAS: point format 7 where there is a gps_time, else 2. A packed rgb becomes the colours; fields
/// that the format has no place for become extra bytes.
class LasFormat {
 public:
  /// `box` holds all points [m]; `offset` is where their integers are 0. A step of the integers is a power of ten,
  /// about 10^-8 of the box. Throws std::invalid_argument for a field whose name is longer than 32 bytes.
  /// `crs`: well-known text of version 1; empty: none.
  LasFormat(const std::vector<Field>& fields, std::uint64_t num_points, const Eigen::AlignedBox3d& box,
            const Eigen::Vector3d& offset, const std::string& crs);

  const std::string& header() const { return header_; }
  std::size_t pointSize() const { return size_; }
  /// Points [first, first + num_points) of the cloud; `target` holds num_points * pointSize() bytes.
  void pack(const Cloud& cloud, std::size_t first, std::size_t num_points, std::uint8_t* target) const;

 private:
  std::vector<Field> placeFields(const std::vector<Field>& fields);
  void makeHeader(std::uint64_t num_points, const Eigen::AlignedBox3d& box, const std::vector<Field>& extra,
                  const std::string& crs);

  int number_ = 2;   ///< of the point format
  double step_ = 1;  ///< m
  Eigen::Vector3d offset_;
  std::string header_;
  std::size_t size_ = 0;
  std::uint8_t flags_ = 0;  ///< the only return of its pulse
  ByteRuns runs_;
};

}  // namespace cloud_colorizer
