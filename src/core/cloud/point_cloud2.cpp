// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause
#include "cloud/point_cloud2.hpp"

#include <cstring>

namespace cloud_colorizer {

namespace {

using Invalid = std::invalid_argument;

/// Fields within point_step, without padding.
std::vector<PlacedField> placedFields(const PointBytes& bytes) {
  std::vector<PlacedField> placed;
  std::uint64_t total = 0;
  for (const auto& [name, offset, count, datatype] : bytes.fields) {
    if (name.empty() || name == "_") continue;
    require<Invalid>(datatype >= 1 && datatype <= 8, "cloud: field ", name, " has the unknown datatype ", datatype);
    const auto type = static_cast<FieldType>(datatype);
    const auto size = sizeOf(type) * std::max<std::uint64_t>(count, 1);
    require<Invalid>(offset <= bytes.point_step && size <= bytes.point_step - offset, "cloud: field ", name,
                     " at offset ", offset, " with ", size, " bytes does not fit into point_step ", bytes.point_step);
    total += size;
    require<Invalid>(total <= bytes.point_step, "cloud: the fields up to ", name, " take ", total,
                     " bytes, but point_step is ", bytes.point_step, ": they overlap");
    placed.push_back(
        {{name, type, static_cast<std::uint32_t>(size / sizeOf(type))}, Wide::kNo, static_cast<std::size_t>(offset)});
  }
  return placed;
}

CloudLayout layoutOf(const PointBytes& bytes) {
  const auto placed = placedFields(bytes);
  try {
    return {placed, static_cast<std::size_t>(bytes.point_step), bytes.is_big_endian != hostIsBigEndian()};
  } catch (const Invalid& error) {
    throw Invalid(std::string("cloud: ") + error.what());
  }
}

/// Bytes from one row to the next. Some drivers leave row_step 0, or write all bytes of an organised cloud into it;
/// with exactly the bytes that the points need there is only one way to read it.
std::uint64_t rowStep(const PointBytes& bytes) {
  const auto& [fields, width, height, point_step, row_step, is_big_endian, data, size] = bytes;
  const bool fits = height == 0 || (row_step / point_step >= width && size / height >= row_step);
  if (fits) return row_step;
  const std::uint64_t packed = width * point_step;
  if (packed > 0 && size % packed == 0 && size / packed == height) return packed;
  require<Invalid>(row_step / point_step >= width, "cloud: row_step ", row_step, " is less than width ", width,
                   " * point_step ", point_step);
  throw Invalid("cloud: data has " + std::to_string(size) + " bytes, but height " + std::to_string(height) +
                " * row_step " + std::to_string(row_step) + " needs " + std::to_string(height * row_step));
}

}  // namespace

bool hostIsBigEndian() {
  const std::uint16_t one = 1;
  std::uint8_t first = 0;
  std::memcpy(&first, &one, 1);
  return first == 0;
}

Cloud cloudOf(const PointBytes& bytes) {
  const auto layout = layoutOf(bytes);
  const auto row_step = rowStep(bytes);
  const auto width = static_cast<std::size_t>(bytes.width);
  const auto height = width > 0 ? static_cast<std::size_t>(bytes.height) : 0;  // four billion empty rows take seconds
  Cloud cloud;
  cloud.fields = layout.fields();
  cloud.positions.resize(3, static_cast<Eigen::Index>(width * height));
  cloud.records.resize(width * height * recordSize(cloud.fields));
  const auto block_points = layout.pointsPerBlock();
  for (std::size_t row = 0; row < height; ++row) {
    for (std::size_t first = 0; first < width; first += block_points) {
      layout.decode(bytes.data + row * row_step + first * layout.stride(), std::min(block_points, width - first), cloud,
                    row * width + first);
    }
  }
  return cloud;
}

std::vector<PointBytes::Entry> packedEntries(const std::vector<Field>& fields) {
  std::vector<PointBytes::Entry> entries;
  std::uint64_t offset = 0;
  const auto add = [&](const Field& field) {
    entries.push_back({field.name, offset, field.count, static_cast<int>(field.type)});
    offset += sizeOf(field.type) * field.count;
  };
  for (const char* name : {"x", "y", "z"}) add({name, FieldType::kFloat32, 1});
  for (const auto& field : fields) add(field);
  return entries;
}

}  // namespace cloud_colorizer
