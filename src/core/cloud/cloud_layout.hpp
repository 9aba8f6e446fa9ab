// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause

/// How the points of a file lie in their bytes, and how they become a Cloud. All decisions are made once a file.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "cloud_colorizer/cloud/cloud.hpp"

namespace cloud_colorizer {

enum class Wide { kNo, kInt64, kUint64 };

/// A field of a file, also x, y, z and padding ("_"). 64 bit integers, which no message can hold, are read as float64.
struct FileField {
  Field field;
  Wide wide = Wide::kNo;
};

enum class Encoding { kAscii, kBinary, kBinaryBigEndian, kCompressed };

struct CloudHeader {
  std::vector<FileField> fields;
  std::uint64_t num_points = 0;
  Encoding encoding = Encoding::kBinary;
};

class CloudLayout {
 public:
  CloudLayout() = default;
  /// Throws std::runtime_error without x, y, z or with fields that checkFields refuses.
  CloudLayout(const CloudHeader& header, const std::string& path);

  const std::vector<Field>& fields() const { return fields_; }  ///< without x, y, z and padding
  std::size_t stride() const { return stride_; }                ///< bytes of a point in the file
  std::size_t numValues() const { return scalars_.size(); }

  /// Turns `num_points` points of the file into points [first, first + num_points) of the cloud. Changes `raw`.
  void decode(std::uint8_t* raw, std::size_t num_points, Cloud& cloud, std::size_t first) const;
  /// One line of text as a point of the file. Empty, or what is wrong with it.
  std::string parseLine(const char* line, std::uint8_t* raw) const;
  /// Points [first, first + num_points) from whole columns, field after field, as binary_compressed stores them.
  void gather(const std::uint8_t* columns, std::size_t num_all, std::size_t first, std::size_t num_points,
              std::uint8_t* raw) const;

 private:
  struct Scalar {
    std::size_t offset;
    FieldType type;
    Wide wide;
  };
  struct Axis {
    std::size_t offset = 0;
    FieldType type = FieldType::kFloat32;
  };
  std::vector<FileField> file_fields_;
  std::vector<Scalar> scalars_;
  std::vector<Field> fields_;
  std::vector<RecordMap> map_;  ///< one, or none before construction
  Axis axes_[3];
  std::size_t stride_ = 0;
  bool swap_bytes_ = false;
  bool has_wide_ = false;
};

}  // namespace cloud_colorizer
