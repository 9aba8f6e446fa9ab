// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause

/// A cloud as files and topics carry it: positions and any other fields, packed.
#pragma once

#include <Eigen/Core>
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

/// Positions in double (a file or a message may carry UTM coordinates) and the records of all other fields, native
/// byte order, n * recordSize(fields) bytes, in the order of `fields`.
struct Cloud {
  Eigen::Matrix3Xd positions;  ///< 3 x n, m
  std::vector<Field> fields;   ///< without x, y, z
  std::vector<std::uint8_t> records;
};

}  // namespace cloud_colorizer
