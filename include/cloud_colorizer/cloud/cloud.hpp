// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause

/// A cloud as files and topics carry it: positions and any other fields, packed.
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

namespace cloud_colorizer {

/// Values as in sensor_msgs/PointField.
enum class FieldType : std::uint8_t { kInt8 = 1, kUint8, kInt16, kUint16, kInt32, kUint32, kFloat32, kFloat64 };

/// f(T{}) with the C++ type of a field's numbers. Throws std::invalid_argument on a value that is no type.
template <class F>
auto withType(FieldType type, F&& f) {
  switch (type) {
    case FieldType::kInt8:
      return f(std::int8_t{});
    case FieldType::kUint8:
      return f(std::uint8_t{});
    case FieldType::kInt16:
      return f(std::int16_t{});
    case FieldType::kUint16:
      return f(std::uint16_t{});
    case FieldType::kInt32:
      return f(std::int32_t{});
    case FieldType::kUint32:
      return f(std::uint32_t{});
    case FieldType::kFloat32:
      return f(float{});
    case FieldType::kFloat64:
      return f(double{});
  }
  throw std::invalid_argument("field type " + std::to_string(static_cast<int>(type)) + " must be 1 to 8");
}

/// "int8" to "float64", and back. Throw std::invalid_argument on a value or name that is none.
std::string toString(FieldType type);
FieldType fieldTypeFromString(const std::string& name);

/// Bytes of one number: 1, 2, 4 or 8.
inline std::size_t sizeOf(FieldType type) {
  return withType(type, [](auto number) { return sizeof number; });
}

/// The number of that type in the sizeOf(type) bytes from `bytes` on, in native byte order; alignment does not matter.
inline double numberAt(const std::uint8_t* bytes, FieldType type) {
  return withType(type, [&](auto number) {
    std::memcpy(&number, bytes, sizeof number);
    return static_cast<double>(number);
  });
}

struct Field {
  std::string name;
  FieldType type = FieldType::kFloat32;
  std::uint32_t count = 1;  ///< numbers of that type, one after the other
};
bool operator==(const Field& a, const Field& b);

/// Bytes of one record of fields packed without padding.
std::size_t recordSize(const std::vector<Field>& fields);

/// A field and where it begins in a record.
struct LocatedField {
  Field field;
  std::size_t offset = 0;
};
/// Nothing where no field has that name.
std::optional<LocatedField> findField(const std::vector<Field>& fields, const std::string& name);

/// Throws std::invalid_argument on fields that no file can hold: an empty name or one with spaces, "_" (padding in a
/// PCD), x, y or z, two of one name, a count of 0.
void checkFields(const std::vector<Field>& fields);

/// Positions in double (a file or a message may carry UTM coordinates) and the records of all other fields, native
/// byte order, n * recordSize(fields) bytes, in the order of `fields`. The frame is that of the file or message.
/// A colour is the field "rgb", FLOAT32 or UINT32, whose bytes are 0x00RRGGBB.
struct Cloud {
  Eigen::Matrix3Xd positions;  ///< 3 x n, m; NaN where a sensor measured nothing
  std::vector<Field> fields;   ///< without x, y, z
  std::vector<std::uint8_t> records;
};

/// Throws std::invalid_argument unless there is one record for every position.
void checkCloud(const Cloud& cloud);

/// Copies of runs of bytes from one record to another; runs that follow each other are one.
class ByteRuns {
 public:
  void add(std::size_t from, std::size_t to, std::size_t size);
  void copy(const std::uint8_t* from, std::uint8_t* to) const {
    for (const auto& run : runs_) std::memcpy(to + run.to, from + run.from, run.size);
  }

 private:
  struct Run {
    std::size_t from, to, size;
  };
  std::vector<Run> runs_;
};

/// How to turn records of some fields into records of others, prepared once. Fields are matched by name, type and
/// count; what has no source becomes zero.
class RecordMap {
 public:
  RecordMap(const std::vector<Field>& from, const std::vector<Field>& to);

  const std::vector<std::string>& dropped() const { return dropped_; }  ///< names in `from` that `to` has not
  const std::vector<std::string>& missing() const { return missing_; }  ///< names in `to` that `from` has not
  /// One record: recordSize() bytes of each list of fields, which must not overlap.
  void copy(const std::uint8_t* from, std::uint8_t* to) const;

 private:
  ByteRuns runs_;
  std::vector<std::string> dropped_, missing_;
  std::size_t to_size_ = 0;
};

}  // namespace cloud_colorizer
