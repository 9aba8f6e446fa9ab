// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause
#include "evaluation/clouds.hpp"

#include <cstring>

#include "cloud_colorizer/base/check.hpp"
#include "cloud_colorizer/cloud/cloud_io.hpp"

namespace cloud_colorizer {
namespace {

using Eigen::Index;

struct Located {
  bool found = false;
  std::size_t offset = 0;
  Field field;
};

Located locate(const std::vector<Field>& fields, const std::string& name) {
  Located located;
  for (const Field& field : fields) {
    if (field.name == name) {
      located.found = true;
      located.field = field;
      return located;
    }
    located.offset += sizeOf(field.type) * field.count;
  }
  return located;
}

template <class T>
double valueAs(const std::uint8_t* bytes) {
  T value{};
  std::memcpy(&value, bytes, sizeof value);
  return static_cast<double>(value);
}

double numberAt(const std::uint8_t* record, const Located& at) {
  const std::uint8_t* bytes = record + at.offset;
  switch (at.field.type) {
    case FieldType::kInt8:
      return valueAs<std::int8_t>(bytes);
    case FieldType::kUint8:
      return valueAs<std::uint8_t>(bytes);
    case FieldType::kInt16:
      return valueAs<std::int16_t>(bytes);
    case FieldType::kUint16:
      return valueAs<std::uint16_t>(bytes);
    case FieldType::kInt32:
      return valueAs<std::int32_t>(bytes);
    case FieldType::kUint32:
      return valueAs<std::uint32_t>(bytes);
    case FieldType::kFloat32:
      return valueAs<float>(bytes);
    case FieldType::kFloat64:
      break;
  }
  return valueAs<double>(bytes);
}

}  // namespace

ColoredCloud coloredCloud(const Cloud& cloud, const std::string& source) {
  const Located rgb = locate(cloud.fields, "rgb"), red = locate(cloud.fields, "red"),
                green = locate(cloud.fields, "green"), blue = locate(cloud.fields, "blue"),
                views = locate(cloud.fields, "view_count");
  const bool separate = red.found && green.found && blue.found;
  require(rgb.found || separate, source, ": the cloud has no colours (no field rgb, and not red, green and blue)");
  require(!rgb.found || sizeOf(rgb.field.type) == 4, source, ": field rgb must have 4 bytes");
  const Index count = cloud.positions.cols();
  const std::size_t bytes = recordSize(cloud.fields);
  ColoredCloud colored{cloud.positions, Values(3, count),
                       std::vector<std::uint16_t>(static_cast<std::size_t>(count), 1)};
  for (Index p = 0; p < count; ++p) {
    const std::uint8_t* record = cloud.records.data() + static_cast<std::size_t>(p) * bytes;
    if (separate) {
      colored.colors.col(p) =
          Eigen::Vector3d(numberAt(record, red), numberAt(record, green), numberAt(record, blue)).cast<float>();
    } else {
      std::uint32_t packed = 0;
      std::memcpy(&packed, record + rgb.offset, sizeof packed);
      for (int c = 0; c < 3; ++c) colored.colors(c, p) = static_cast<float>(packed >> (16 - 8 * c) & 0xffU);
    }
    if (views.found) colored.count[static_cast<std::size_t>(p)] = static_cast<std::uint16_t>(numberAt(record, views));
  }
  return colored;
}

ColoredCloud readColoredCloud(const std::string& path) {
  CloudReader reader(path);
  ColoredCloud all = coloredCloud(reader.read(reader.numPoints()), path);
  Index kept = 0;
  for (Index p = 0; p < all.positions.cols(); ++p) {
    if (all.count[static_cast<std::size_t>(p)] == 0 || !all.positions.col(p).allFinite()) continue;
    all.positions.col(kept) = all.positions.col(p).eval();
    all.colors.col(kept) = all.colors.col(p).eval();
    all.count[static_cast<std::size_t>(kept++)] = all.count[static_cast<std::size_t>(p)];
  }
  require(kept > 0, path, ": the cloud has no coloured point");
  all.positions.conservativeResize(3, kept);
  all.colors.conservativeResize(3, kept);
  all.count.resize(static_cast<std::size_t>(kept));
  return all;
}

}  // namespace cloud_colorizer
