// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause
#include "cloud/cloud_layout.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>

#include "base/text.hpp"
#include "cloud_colorizer/base/check.hpp"

namespace cloud_colorizer {

namespace {

void swapBytes(std::uint8_t* raw, std::size_t stride, std::size_t num_points, std::size_t size) {
  for (std::size_t i = 0; i < num_points; ++i, raw += stride) std::reverse(raw, raw + size);
}

template <class Integer>
void integersToDouble(std::uint8_t* raw, std::size_t stride, std::size_t num_points) {
  for (std::size_t i = 0; i < num_points; ++i, raw += stride) {
    Integer integer = 0;
    std::memcpy(&integer, raw, sizeof integer);
    const auto value = static_cast<double>(integer);
    std::memcpy(raw, &value, sizeof value);
  }
}

/// Column `axis` of a 3 x n matrix.
void copyAxis(const std::uint8_t* raw, std::size_t stride, std::size_t num_points, FieldType type, double* target) {
  withType(type, [&](auto zero) {
    for (std::size_t i = 0; i < num_points; ++i, raw += stride, target += 3) {
      auto value = zero;
      std::memcpy(&value, raw, sizeof value);
      *target = static_cast<double>(value);
    }
  });
}

/// False when an integer type cannot hold the number.
bool storeNumber(double number, FieldType type, std::uint8_t* target) {
  return withType(type, [&](auto value) {
    using T = decltype(value);
    if constexpr (std::numeric_limits<T>::is_integer) {
      if (!(number >= static_cast<double>(std::numeric_limits<T>::min()) &&
            number <= static_cast<double>(std::numeric_limits<T>::max()) && number == std::floor(number))) {
        return false;
      }
    }
    value = static_cast<T>(number);
    std::memcpy(target, &value, sizeof value);
    return true;
  });
}

}  // namespace

CloudLayout::CloudLayout(const CloudHeader& header, const std::string& path)
    : file_fields_(header.fields), swap_bytes_(header.encoding == Encoding::kBinaryBigEndian) {
  std::vector<Field> all;
  bool found[3] = {false, false, false};
  for (const auto& [field, wide] : header.fields) {
    const bool is_axis = field.name == "x" || field.name == "y" || field.name == "z";
    if (is_axis) {
      const auto axis = static_cast<std::size_t>(field.name[0] - 'x');
      require(field.count == 1 && !found[axis], path, ": the field ", field.name, " must be there once, as one number");
      found[axis] = true;
      axes_[axis] = {stride_, field.type};
    } else if (field.name != "_") {
      fields_.push_back(field);
    }
    for (std::uint32_t i = 0; i < field.count; ++i) {
      scalars_.push_back({stride_, field.type, wide});
      stride_ += sizeOf(field.type);
    }
    all.push_back(field);
    has_wide_ = has_wide_ || wide != Wide::kNo;
  }
  require(found[0] && found[1] && found[2], path, " has no positions: it needs the fields x, y and z");
  try {
    checkFields(fields_);
  } catch (const std::invalid_argument& error) {
    throw std::runtime_error(path + ": " + error.what());
  }
  map_.emplace_back(all, fields_);
}

void CloudLayout::decode(std::uint8_t* raw, std::size_t num_points, Cloud& cloud, std::size_t first) const {
  if (swap_bytes_ || has_wide_) {
    for (const auto& scalar : scalars_) {
      auto* values = raw + scalar.offset;
      if (swap_bytes_) swapBytes(values, stride_, num_points, sizeOf(scalar.type));
      if (scalar.wide == Wide::kInt64) integersToDouble<std::int64_t>(values, stride_, num_points);
      if (scalar.wide == Wide::kUint64) integersToDouble<std::uint64_t>(values, stride_, num_points);
    }
  }
  for (std::size_t axis = 0; axis < 3; ++axis) {
    copyAxis(raw + axes_[axis].offset, stride_, num_points, axes_[axis].type,
             cloud.positions.data() + 3 * first + axis);
  }
  const auto record_size = recordSize(fields_);
  if (record_size == 0) return;
  auto* record = cloud.records.data() + first * record_size;
  for (std::size_t i = 0; i < num_points; ++i) map_[0].copy(raw + i * stride_, record + i * record_size);
}

std::string CloudLayout::parseLine(const char* line, std::uint8_t* raw) const {
  for (const auto& scalar : scalars_) {
    double number = 0;
    if (!parseDouble(line, number)) return "it needs " + std::to_string(scalars_.size()) + " numbers";
    auto* target = raw + scalar.offset;
    if (scalar.wide == Wide::kInt64) {
      const auto integer = static_cast<std::int64_t>(std::abs(number) < 9e18 ? number : 0);
      std::memcpy(target, &integer, sizeof integer);
    } else if (scalar.wide == Wide::kUint64) {
      const auto integer = static_cast<std::uint64_t>(number >= 0 && number < 1.8e19 ? number : 0);
      std::memcpy(target, &integer, sizeof integer);
    } else if (!storeNumber(number, scalar.type, target)) {
      return "the value " + formatDouble(number) + " does not fit its field";
    }
  }
  while (*line == ' ' || *line == '\t') ++line;
  return *line == '\0' ? "" : "it has more than " + std::to_string(scalars_.size()) + " numbers";
}

void CloudLayout::gather(const std::uint8_t* columns, std::size_t num_all, std::size_t first, std::size_t num_points,
                         std::uint8_t* raw) const {
  std::size_t offset = 0;
  for (const auto& entry : file_fields_) {
    const auto size = sizeOf(entry.field.type) * entry.field.count;
    const auto* source = columns + offset * num_all + first * size;
    for (std::size_t i = 0; i < num_points; ++i) std::memcpy(raw + i * stride_ + offset, source + i * size, size);
    offset += size;
  }
}

}  // namespace cloud_colorizer
