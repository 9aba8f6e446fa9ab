// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause

/// A cloud as files and topics carry it: positions and any other fields, packed.
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

namespace cloud_colorizer {

/// Values as in sensor_msgs/PointField.
enum class FieldType : std::uint8_t { kInt8 = 1, kUint8, kInt16, kUint16, kInt32, kUint32, kFloat32, kFloat64 };
std::size_t sizeOf(FieldType type);

struct Field {
  std::string name;
  FieldType type = FieldType::kFloat32;
  std::uint32_t count = 1;
};
bool operator==(const Field& a, const Field& b);

/// Bytes of one record of fields packed without padding.
std::size_t recordSize(const std::vector<Field>& fields);

/// Throws std::invalid_argument on fields that no file can hold: an empty name or one with spaces, "_" (padding in a
/// PCD), x, y or z, two of one name, a count of 0.
void checkFields(const std::vector<Field>& fields);

/// Positions in double (a file or a message may carry UTM coordinates) and the records of all other fields, native
/// byte order, n * recordSize(fields) bytes, in the order of `fields`.
struct Cloud {
  Eigen::Matrix3Xd positions;  ///< 3 x n, m
  std::vector<Field> fields;   ///< without x, y, z
  std::vector<std::uint8_t> records;
};

/// Throws std::invalid_argument unless there is one record for every position.
void checkCloud(const Cloud& cloud);

/// How to turn records of some fields into records of others: a few copies of runs of bytes a record, prepared once.
/// Fields are matched by name, type and count; what has no source becomes zero.
class RecordMap {
 public:
  RecordMap(const std::vector<Field>& from, const std::vector<Field>& to);

  const std::vector<std::string>& dropped() const { return dropped_; }  ///< names in `from` that `to` has not
  const std::vector<std::string>& missing() const { return missing_; }  ///< names in `to` that `from` has not
  void copy(const std::uint8_t* from, std::uint8_t* to) const;          ///< one record

 private:
  struct Run {
    std::size_t from, to, size;
  };
  std::vector<Run> runs_;
  std::vector<std::string> dropped_, missing_;
  std::size_t to_size_ = 0;
};

}  // namespace cloud_colorizer
