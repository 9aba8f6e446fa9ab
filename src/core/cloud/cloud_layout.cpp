// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause
#include "cloud/cloud_layout.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <utility>

#include "base/text.hpp"
#include "cloud_colorizer/base/check.hpp"

namespace cloud_colorizer {

namespace {

constexpr std::size_t kMaxValues = 1'000'000;  ///< of a point

const char* const kComma = "it has a comma; decimals are written with a point, and numbers apart with a space";

/// f(T{}) with the type that a number has in the bytes.
template <class F>
void withStoredType(FieldType type, Wide wide, F&& f) {
  if (wide == Wide::kInt64) {
    f(std::int64_t{});
  } else if (wide == Wide::kUint64) {
    f(std::uint64_t{});
  } else {
    withType(type, f);
  }
}

template <class T>
T readNumber(const std::uint8_t* raw, bool swap_bytes) {
  std::array<std::uint8_t, sizeof(T)> bytes;
  std::memcpy(bytes.data(), raw, sizeof(T));
  if (swap_bytes) std::reverse(bytes.begin(), bytes.end());
  T number;
  std::memcpy(&number, bytes.data(), sizeof(T));
  return number;
}

/// False when an integer type cannot hold the number.
bool storeNumber(double number, FieldType type, std::uint8_t* target) {
  return withType(type, [&](auto value) {
    using T = decltype(value);
    if constexpr (std::numeric_limits<T>::is_integer) {
      if (std::isnan(number)) number = 0;  // as writers do that know one kind of no value
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

std::string namesOf(const std::vector<PlacedField>& fields) {
  std::string text;
  for (const PlacedField& placed : fields) {
    if (placed.field.name != "_") text += (text.empty() ? "" : ", ") + placed.field.name;
  }
  return text.empty() ? "none" : text;
}

}  // namespace

CloudLayout::CloudLayout(std::vector<PlacedField> fields, std::size_t stride, bool swap_bytes)
    : placed_(std::move(fields)), stride_(stride), swap_bytes_(swap_bytes) {
  using Invalid = std::invalid_argument;
  std::array<bool, 3> found{};
  std::size_t num_values = 0;
  for (const auto& [field, wide, offset] : placed_) {
    num_values += field.count;
    require<Invalid>(num_values <= kMaxValues, "a point of ", num_values, " numbers is too large; at most ", kMaxValues,
                     " can be read");
    const auto size = sizeOf(field.type);
    const auto axis = field.name.size() == 1 ? std::string("xyz").find(lowerCase(field.name)) : std::string::npos;
    const bool is_kept = axis == std::string::npos && field.name != "_";
    for (std::size_t i = 0; i < field.count; ++i) {
      scalars_.push_back({offset + i * size, field.type, wide});
      if (is_kept && ((swap_bytes && size > 1) || wide != Wide::kNo)) {
        converted_.push_back({record_size_ + i * size, field.type, wide});
      }
    }
    if (axis != std::string::npos) {
      require<Invalid>(field.count == 1, "the field ", field.name, " must be one number, not ", field.count);
      require<Invalid>(!found[axis], "the field ", field.name, " is there twice; it must be there once");
      found[axis] = true;
      axes_[axis] = {offset, field.type, wide};
    } else if (is_kept) {
      fields_.push_back(field);
      runs_.add(offset, record_size_, size * field.count);
      record_size_ += size * field.count;
    }
  }
  for (std::size_t axis = 0; axis < 3; ++axis) {
    require<Invalid>(found[axis], "there is no field ", "xyz"[axis], "; a cloud needs the fields x, y and z, and has ",
                     namesOf(placed_));
  }
  checkFields(fields_);
}

CloudLayout CloudLayout::ofFile(const CloudHeader& header, const std::string& path) {
  auto fields = header.fields;
  std::size_t stride = 0;
  for (auto& [field, wide, offset] : fields) {
    if (header.encoding == Encoding::kAscii) wide = Wide::kNo;  // the line is read as float64
    offset = stride;
    stride += sizeOf(field.type) * field.count;
  }
  try {
    return {std::move(fields), stride, header.encoding == Encoding::kBinaryBigEndian};
  } catch (const std::invalid_argument& error) {
    throw std::runtime_error(path + ": " + error.what());
  }
}

/// Column of a 3 x n matrix.
void CloudLayout::decodeAxis(const std::uint8_t* raw, std::size_t num_points, const Scalar& axis,
                             double* target) const {
  withStoredType(axis.type, axis.wide, [&](auto zero) {
    raw += axis.offset;
    for (std::size_t i = 0; i < num_points; ++i, raw += stride_, target += 3) {
      *target = static_cast<double>(readNumber<decltype(zero)>(raw, swap_bytes_));
    }
  });
}

void CloudLayout::decode(const std::uint8_t* raw, std::size_t num_points, Cloud& cloud, std::size_t first) const {
  for (std::size_t axis = 0; axis < 3; ++axis) {
    decodeAxis(raw, num_points, axes_[axis], cloud.positions.data() + 3 * first + axis);
  }
  if (record_size_ == 0) return;
  auto* const records = cloud.records.data() + first * record_size_;
  for (std::size_t i = 0; i < num_points; ++i) runs_.copy(raw + i * stride_, records + i * record_size_);
  for (const auto& scalar : converted_) {
    withStoredType(scalar.type, scalar.wide, [&](auto zero) {
      for (std::size_t i = 0; i < num_points; ++i) {
        auto* const bytes = records + i * record_size_ + scalar.offset;
        const auto number = readNumber<decltype(zero)>(bytes, swap_bytes_);
        const auto wide = static_cast<double>(number);
        std::memcpy(bytes, scalar.wide == Wide::kNo ? static_cast<const void*>(&number) : &wide, sizeof number);
      }
    });
  }
}

std::string CloudLayout::parseLine(const char* line, std::uint8_t* raw) const {
  for (const auto& scalar : scalars_) {
    double number = 0;
    if (!parseDouble(line, number)) {
      return *line == ',' ? kComma : "it needs " + std::to_string(scalars_.size()) + " numbers";
    }
    if (!storeNumber(number, scalar.type, raw + scalar.offset)) {
      return "the value " + formatDouble(number) + " does not fit its field";
    }
  }
  while (*line == ' ' || *line == '\t') ++line;
  if (*line == ',') return kComma;
  return *line == '\0' ? "" : "it has more than " + std::to_string(scalars_.size()) + " numbers";
}

void CloudLayout::gather(const std::uint8_t* columns, std::size_t num_all, std::size_t first, std::size_t num_points,
                         std::uint8_t* raw) const {
  for (const auto& [field, wide, offset] : placed_) {
    const auto size = sizeOf(field.type) * field.count;
    const auto* source = columns + offset * num_all + first * size;
    for (std::size_t i = 0; i < num_points; ++i) std::memcpy(raw + i * stride_ + offset, source + i * size, size);
  }
}

PackedFormat wholeRecords(const std::vector<Field>& fields, bool double_positions) {
  PackedFormat format{double_positions, {}, recordSize(fields)};
  format.runs.add(0, 0, format.record_size);
  return format;
}

void PackedFormat::pack(const Cloud& cloud, std::size_t first, std::size_t num_points, std::uint8_t* target) const {
  const auto position_size = pointSize() - record_size, source_size = recordSize(cloud.fields);
  const auto* record = cloud.records.data() + first * source_size;
  for (std::size_t i = 0; i < num_points; ++i, record += source_size, target += pointSize()) {
    const Eigen::Vector3d position = cloud.positions.col(static_cast<Eigen::Index>(first + i));
    const Eigen::Vector3f rounded = position.cast<float>();
    std::memcpy(target, double_positions ? static_cast<const void*>(position.data()) : rounded.data(), position_size);
    runs.copy(record, target + position_size);
  }
}

}  // namespace cloud_colorizer
