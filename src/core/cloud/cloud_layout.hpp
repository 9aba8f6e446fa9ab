// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause

/// How the points of a file or a message lie in their bytes, and how they become a Cloud and back. All decisions are
/// made once a file or message.
#pragma once

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "cloud_colorizer/cloud/cloud.hpp"

namespace cloud_colorizer {

enum class Wide { kNo, kInt64, kUint64 };

/// A field where it lies in the bytes of a point; also x, y, z and padding ("_"). 64 bit integers, which a Cloud cannot
/// hold, are read as float64.
struct PlacedField {
  Field field;
  Wide wide = Wide::kNo;
  std::size_t offset = 0;
};

enum class Encoding { kAscii, kBinary, kBinaryBigEndian, kCompressed };

/// A list in every point, of any length, that is passed over.
struct SkippedList {
  std::size_t before = 0;  ///< index of the field that follows it
  FieldType length_type = FieldType::kUint8;
  std::size_t item_size = 0;  ///< bytes
};

struct CloudHeader {
  std::vector<PlacedField> fields;  ///< their offsets do not count: one follows the other
  std::vector<SkippedList> lists;
  /// VIEWPOINT of a PCD; scale and offset of a LAS.
  Eigen::Affine3d map_from_points = Eigen::Affine3d::Identity();
  std::uint64_t num_points = 0;
  std::string crs;  ///< as wellKnownText() takes it, of a LAS; empty: unknown
  Encoding encoding = Encoding::kBinary;
};

class CloudLayout {
 public:
  /// Throws std::invalid_argument without x, y, z or with fields that checkFields refuses. Every field must lie within
  /// `stride`, the bytes from a point to the next.
  CloudLayout(std::vector<PlacedField> fields, std::size_t stride, bool swap_bytes);
  /// Of a file. The errors name it and are std::runtime_error.
  static CloudLayout ofFile(const CloudHeader& header, const std::string& path);

  const std::vector<Field>& fields() const { return fields_; }  ///< without x, y, z and padding
  std::size_t stride() const { return stride_; }
  /// As many as are well decoded at a time: their raw bytes stay in the cache.
  std::size_t pointsPerBlock() const { return std::max<std::size_t>(1, (std::size_t{1} << 18U) / stride_); }
  std::size_t numValues() const { return scalars_.size(); }

  /// Turns the `num_points` points at `raw` into points [first, first + num_points) of the cloud.
  void decode(const std::uint8_t* raw, std::size_t num_points, Cloud& cloud, std::size_t first) const;
  /// One line of text as a point of the file. Empty, or what is wrong with it.
  std::string parseLine(const char* line, std::uint8_t* raw) const;
  /// Points [first, first + num_points) from whole columns, field after field, as binary_compressed stores them.
  void gather(const std::uint8_t* columns, std::size_t num_all, std::size_t first, std::size_t num_points,
              std::uint8_t* raw) const;

 private:
  struct Scalar {
    std::size_t offset = 0;
    FieldType type = FieldType::kFloat32;
    Wide wide = Wide::kNo;
  };
  void decodeAxis(const std::uint8_t* raw, std::size_t num_points, const Scalar& axis, double* target) const;

  std::vector<PlacedField> placed_;
  std::vector<Scalar> scalars_;    ///< where the numbers are in the bytes
  std::vector<Scalar> converted_;  ///< where those are in a record that are not copied as they are
  std::vector<Field> fields_;
  std::array<Scalar, 3> axes_;
  ByteRuns runs_;
  std::size_t stride_ = 0, record_size_ = 0;
  bool swap_bytes_ = false;
};

/// How a Cloud becomes the points of a file or message: x, y, z as float or double, then the runs of its record.
struct PackedFormat {
  bool double_positions = false;
  ByteRuns runs;
  std::size_t record_size = 0;  ///< bytes after the position

  std::size_t pointSize() const { return 3 * (double_positions ? sizeof(double) : sizeof(float)) + record_size; }
  /// Points [first, first + num_points) of the cloud; `target` holds num_points * pointSize() bytes.
  void pack(const Cloud& cloud, std::size_t first, std::size_t num_points, std::uint8_t* target) const;
};
PackedFormat wholeRecords(const std::vector<Field>& fields, bool double_positions);

}  // namespace cloud_colorizer
