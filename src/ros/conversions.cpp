// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause

#include "cloud_colorizer/ros/conversions.hpp"

#include <algorithm>
#include <array>
#include <cstring>
#include <limits>
#include <set>

#include "cloud_colorizer/base/check.hpp"

namespace cloud_colorizer {
namespace {

using sensor_msgs::PointCloud2;
using sensor_msgs::PointField;
using Invalid = std::invalid_argument;

bool hostIsBigEndian() {
  const std::uint16_t one = 1;
  std::uint8_t first = 0;
  std::memcpy(&first, &one, 1);
  return first == 0;
}

/// Reads a number of type T at `bytes`, with its bytes reversed where asked.
template <class T>
double readNumber(const std::uint8_t* bytes, bool swap) {
  std::uint8_t copy[sizeof(T)];
  std::memcpy(copy, bytes, sizeof(T));
  if (swap) std::reverse(copy, copy + sizeof(T));
  T value;
  std::memcpy(&value, copy, sizeof(T));
  return static_cast<double>(value);
}

using NumberReader = double (*)(const std::uint8_t*, bool);
NumberReader numberReader(FieldType type) {
  switch (type) {
    case FieldType::kInt8:
      return readNumber<std::int8_t>;
    case FieldType::kUint8:
      return readNumber<std::uint8_t>;
    case FieldType::kInt16:
      return readNumber<std::int16_t>;
    case FieldType::kUint16:
      return readNumber<std::uint16_t>;
    case FieldType::kInt32:
      return readNumber<std::int32_t>;
    case FieldType::kUint32:
      return readNumber<std::uint32_t>;
    case FieldType::kFloat32:
      return readNumber<float>;
    case FieldType::kFloat64:
      return readNumber<double>;
  }
  return nullptr;
}

/// A run of bytes that is copied from every point of the message into every record.
struct Segment {
  std::size_t from = 0, to = 0, size = 0;
  std::size_t element = 1;  ///< bytes of a number, for the byte order
};

struct Layout {
  struct Axis {
    std::size_t offset = 0;
    FieldType type = FieldType::kFloat32;
    bool found = false;
  };
  std::array<Axis, 3> axes;
  std::vector<Field> fields;
  std::vector<Segment> segments;
  bool swap = false;
};

void checkSizes(const PointCloud2& message) {
  const std::uint64_t row = std::uint64_t{message.width} * message.point_step;
  require<Invalid>(message.height == 0 || message.row_step >= row, "cloud: row_step ", message.row_step,
                   " is less than width ", message.width, " * point_step ", message.point_step);
  const std::uint64_t need = std::uint64_t{message.row_step} * message.height;
  require<Invalid>(message.data.size() >= need, "cloud: data has ", message.data.size(), " bytes, but height ",
                   message.height, " * row_step ", message.row_step, " needs ", need);
}

void addSegment(std::vector<Segment>& segments, const Segment& segment, bool swap) {
  if (!segments.empty() && !swap) {
    Segment& last = segments.back();
    if (last.from + last.size == segment.from && last.to + last.size == segment.to) {
      last.size += segment.size;
      return;
    }
  }
  segments.push_back(segment);
}

Layout readLayout(const PointCloud2& message) {
  Layout layout;
  layout.swap = (message.is_bigendian != 0) != hostIsBigEndian();
  std::set<std::string> names;
  std::size_t record = 0, used = 0;
  for (const PointField& field : message.fields) {
    if (field.name.empty() || field.name == "_") continue;  // padding
    require<Invalid>(field.datatype >= 1 && field.datatype <= 8, "cloud: field ", field.name,
                     " has the unknown datatype ", static_cast<int>(field.datatype));
    require<Invalid>(names.insert(field.name).second, "cloud: field ", field.name, " appears twice");
    const FieldType type = static_cast<FieldType>(field.datatype);
    const std::uint32_t count = std::max<std::uint32_t>(field.count, 1);  // 0 is a common mistake of drivers
    const std::uint64_t size = std::uint64_t{sizeOf(type)} * count;
    require<Invalid>(field.offset + size <= message.point_step, "cloud: field ", field.name, " at offset ",
                     field.offset, " with ", size, " bytes does not fit into point_step ", message.point_step);
    used += size;
    require<Invalid>(used <= message.point_step, "cloud: the fields up to ", field.name, " take ", used,
                     " bytes, but point_step is ", message.point_step, ": they overlap");
    const std::size_t axis = field.name.size() == 1 ? std::string("xyz").find(field.name) : std::string::npos;
    if (axis != std::string::npos) {
      layout.axes[axis] = {field.offset, type, true};
      continue;
    }
    layout.fields.push_back({field.name, type, count});
    addSegment(layout.segments, {field.offset, record, static_cast<std::size_t>(size), sizeOf(type)}, layout.swap);
    record += static_cast<std::size_t>(size);
  }
  for (std::size_t axis = 0; axis < 3; ++axis) {
    require<Invalid>(layout.axes[axis].found, "cloud: there is no field ", "xyz"[axis]);
  }
  return layout;
}

void copySegments(const Layout& layout, const std::uint8_t* point, std::uint8_t* record) {
  for (const Segment& segment : layout.segments) {
    std::memcpy(record + segment.to, point + segment.from, segment.size);
    if (!layout.swap || segment.element == 1) continue;
    for (std::size_t k = 0; k < segment.size; k += segment.element) {
      std::reverse(record + segment.to + k, record + segment.to + k + segment.element);
    }
  }
}

/// The common case: x, y, z are neighbouring floats in native byte order.
bool hasPlainPositions(const Layout& layout) {
  const auto& [x, y, z] = layout.axes;
  return !layout.swap && x.type == FieldType::kFloat32 && y.type == x.type && z.type == x.type &&
         y.offset == x.offset + 4 && z.offset == x.offset + 8;
}

}  // namespace

Cloud cloudFromMessage(const PointCloud2& message) {
  const Layout layout = readLayout(message);
  checkSizes(message);
  const std::size_t record = recordSize(layout.fields);
  const std::size_t num_points = std::size_t{message.width} * message.height;
  Cloud cloud;
  cloud.fields = layout.fields;
  cloud.positions.resize(3, static_cast<Eigen::Index>(num_points));
  cloud.records.resize(num_points * record);
  const bool plain = hasPlainPositions(layout);
  std::array<NumberReader, 3> readers;
  for (std::size_t a = 0; a < 3; ++a) readers[a] = numberReader(layout.axes[a].type);

  double* position = cloud.positions.data();
  std::uint8_t* out = cloud.records.data();
  for (std::uint32_t row = 0; row < message.height; ++row) {
    const std::uint8_t* point = message.data.data() + std::size_t{row} * message.row_step;
    for (std::uint32_t i = 0; i < message.width; ++i, point += message.point_step, position += 3, out += record) {
      if (plain) {
        float xyz[3];
        std::memcpy(xyz, point + layout.axes[0].offset, sizeof(xyz));
        for (std::size_t a = 0; a < 3; ++a) position[a] = static_cast<double>(xyz[a]);
      } else {
        for (std::size_t a = 0; a < 3; ++a) position[a] = readers[a](point + layout.axes[a].offset, layout.swap);
      }
      copySegments(layout, point, out);
    }
  }
  return cloud;
}

namespace {

PointField makeField(const std::string& name, std::size_t offset, FieldType type, std::uint32_t count) {
  PointField field;
  field.name = name;
  field.offset = static_cast<std::uint32_t>(offset);
  field.datatype = static_cast<std::uint8_t>(type);
  field.count = count;
  return field;
}

std::vector<PointField> packedFields(const std::vector<Field>& fields) {
  std::vector<PointField> result;
  std::size_t offset = 0;
  for (const char* name : {"x", "y", "z"}) {
    result.push_back(makeField(name, offset, FieldType::kFloat32, 1));
    offset += 4;
  }
  for (const Field& field : fields) {
    result.push_back(makeField(field.name, offset, field.type, field.count));
    offset += sizeOf(field.type) * field.count;
  }
  return result;
}

}  // namespace

void appendToMessage(const Cloud& cloud, PointCloud2& message) {
  const std::vector<PointField> fields = packedFields(cloud.fields);
  if (message.fields.empty()) message.fields = fields;
  require<Invalid>(message.fields == fields, "cannot append a cloud with other fields to a message");
  const std::size_t record = recordSize(cloud.fields), step = 12 + record;
  const std::size_t added = static_cast<std::size_t>(cloud.positions.cols());
  const std::size_t old_size = message.data.size(), new_size = old_size + added * step;
  require<Invalid>(new_size <= std::numeric_limits<std::uint32_t>::max(), "a message cannot hold ", new_size, " bytes");

  message.data.resize(new_size);
  std::uint8_t* out = message.data.data() + old_size;
  const std::uint8_t* in = cloud.records.data();
  for (std::size_t i = 0; i < added; ++i, out += step, in += record) {
    const Eigen::Vector3f position = cloud.positions.col(static_cast<Eigen::Index>(i)).cast<float>();
    std::memcpy(out, position.data(), 12);
    if (record > 0) std::memcpy(out + 12, in, record);
  }
  message.height = 1;
  message.width = static_cast<std::uint32_t>(new_size / step);
  message.point_step = static_cast<std::uint32_t>(step);
  message.row_step = static_cast<std::uint32_t>(new_size);
  message.is_bigendian = hostIsBigEndian();
  message.is_dense = true;
}

}  // namespace cloud_colorizer
