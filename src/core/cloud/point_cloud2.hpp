// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause

/// A Cloud from and to what has the members of sensor_msgs/PointCloud2: the message itself, and pcl::PCLPointCloud2.
#pragma once

#include <algorithm>
#include <cstdint>
#include <limits>
#include <vector>

#include "cloud/cloud_layout.hpp"
#include "cloud_colorizer/base/check.hpp"
#include "cloud_colorizer/cloud/cloud.hpp"

namespace cloud_colorizer {

/// The members of such a message; the bytes stay where they are.
struct PointBytes {
  struct Entry {
    std::string name;
    std::uint64_t offset = 0, count = 0;
    int datatype = 0;
  };
  std::vector<Entry> fields;
  std::uint64_t width = 0, height = 0, point_step = 0, row_step = 0;
  bool is_big_endian = false;
  const std::uint8_t* data = nullptr;
  std::uint64_t size = 0;
};

/// Any field order, padding between fields and rows, byte order and number types. A count of 0, a common mistake of
/// drivers, is 1. NaN passes through. Throws std::invalid_argument for a missing x, y or z, a field twice, fields that
/// overlap so much that they exceed point_step, or sizes that contradict each other.
Cloud cloudOf(const PointBytes& bytes);

/// x, y, z as FLOAT32, then the fields.
std::vector<PointBytes::Entry> packedEntries(const std::vector<Field>& fields);

bool hostIsBigEndian();

template <class Message>
Cloud cloudFrom(const Message& message) {
  PointBytes bytes{{},
                   message.width,
                   message.height,
                   message.point_step,
                   message.row_step,
                   message.is_bigendian != 0,
                   message.data.data(),
                   message.data.size()};
  for (const auto& field : message.fields) {
    bytes.fields.push_back({field.name, field.offset, field.count, field.datatype});
  }
  return cloudOf(bytes);
}

/// Appends to a message that is empty or was made by this function from the same fields: packed, x y z as FLOAT32,
/// height 1, native byte order. Throws std::invalid_argument where the fields differ or the data would not fit into
/// 4 GB.
template <class Message>
void appendCloud(const Cloud& cloud, Message& message) {
  const auto entries = packedEntries(cloud.fields);
  const bool is_first = message.fields.empty();
  if (is_first) {
    message.fields.resize(entries.size());
    for (std::size_t k = 0; k < entries.size(); ++k) {
      auto& field = message.fields[k];
      field.name = entries[k].name;
      field.offset = static_cast<std::uint32_t>(entries[k].offset);
      field.datatype = static_cast<std::uint8_t>(entries[k].datatype);
      field.count = static_cast<std::uint32_t>(entries[k].count);
    }
  }
  const bool is_same =
      std::equal(entries.begin(), entries.end(), message.fields.begin(), message.fields.end(),
                 [](const PointBytes::Entry& a, const auto& b) {
                   return a.name == b.name && a.offset == b.offset && a.count == b.count && a.datatype == b.datatype;
                 });
  require<std::invalid_argument>(is_same, "cannot append a cloud with other fields to a message");
  checkCloud(cloud);
  const auto format = wholeRecords(cloud.fields, false);
  const auto num_added = static_cast<std::size_t>(cloud.positions.cols());
  const auto old_size = message.data.size(), new_size = old_size + num_added * format.pointSize();
  require<std::invalid_argument>(new_size <= std::numeric_limits<std::uint32_t>::max(), "a message cannot hold ",
                                 new_size, " bytes");
  message.data.resize(new_size);
  format.pack(cloud, 0, num_added, message.data.data() + old_size);
  message.height = 1;
  message.width = static_cast<std::uint32_t>(new_size / format.pointSize());
  message.point_step = static_cast<std::uint32_t>(format.pointSize());
  message.row_step = static_cast<std::uint32_t>(new_size);
  message.is_bigendian = hostIsBigEndian();
  message.is_dense = (is_first || message.is_dense) && cloud.positions.allFinite();
}

}  // namespace cloud_colorizer
