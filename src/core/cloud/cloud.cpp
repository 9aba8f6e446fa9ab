// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause
#include "cloud_colorizer/cloud/cloud.hpp"

#include <algorithm>
#include <array>
#include <cstring>
#include <set>

#include "cloud_colorizer/base/check.hpp"

namespace cloud_colorizer {

namespace {

constexpr std::array<const char*, 8> kTypeNames{"int8",  "uint8",  "int16",   "uint16",
                                                "int32", "uint32", "float32", "float64"};

}  // namespace

std::string toString(FieldType type) {
  sizeOf(type);  // throws on what is no type
  return kTypeNames[static_cast<std::size_t>(type) - 1];
}

FieldType fieldTypeFromString(const std::string& name) {
  const auto found = std::find(kTypeNames.begin(), kTypeNames.end(), name);
  require<std::invalid_argument>(found != kTypeNames.end(), "field type \"", name, "\" is unknown");
  return static_cast<FieldType>(found - kTypeNames.begin() + 1);
}

bool operator==(const Field& a, const Field& b) {
  return a.name == b.name && a.type == b.type && a.count == b.count;
}

std::size_t recordSize(const std::vector<Field>& fields) {
  std::size_t size = 0;
  for (const auto& field : fields) size += sizeOf(field.type) * field.count;
  return size;
}

std::optional<LocatedField> findField(const std::vector<Field>& fields, const std::string& name) {
  std::size_t offset = 0;
  for (const auto& field : fields) {
    if (field.name == name) return LocatedField{field, offset};
    offset += sizeOf(field.type) * field.count;
  }
  return std::nullopt;
}

void checkFields(const std::vector<Field>& fields) {
  std::set<std::string> names{"x", "y", "z", "_"};
  for (const auto& field : fields) {
    const bool printable = std::all_of(field.name.begin(), field.name.end(), [](unsigned char c) { return c > ' '; });
    require<std::invalid_argument>(!field.name.empty() && printable, "field name \"", field.name,
                                   "\" must be a word without spaces");
    require<std::invalid_argument>(names.insert(field.name).second, "field name \"", field.name,
                                   "\" is reserved or there twice; rename or leave out that field");
    require<std::invalid_argument>(field.count > 0, "field \"", field.name, "\" has count 0; it must be at least 1");
    sizeOf(field.type);
  }
}

void checkCloud(const Cloud& cloud) {
  const auto num_points = static_cast<std::size_t>(cloud.positions.cols());
  const auto size = recordSize(cloud.fields);
  require<std::invalid_argument>(cloud.records.size() == num_points * size, "a cloud of ", num_points,
                                 " points with records of ", size, " bytes must have ", num_points * size,
                                 " bytes of records, not ", cloud.records.size());
}

void ByteRuns::add(std::size_t from, std::size_t to, std::size_t size) {
  if (size == 0) return;
  if (!runs_.empty() && runs_.back().from + runs_.back().size == from && runs_.back().to + runs_.back().size == to) {
    runs_.back().size += size;
  } else {
    runs_.push_back({from, to, size});
  }
}

RecordMap::RecordMap(const std::vector<Field>& from, const std::vector<Field>& to) {
  for (const auto& field : from) {
    if (std::find(to.begin(), to.end(), field) == to.end()) dropped_.push_back(field.name);
  }
  for (const auto& field : to) {
    const auto size = sizeOf(field.type) * field.count;
    const auto source = findField(from, field.name);
    if (source && source->field == field) {
      runs_.add(source->offset, to_size_, size);
    } else {
      missing_.push_back(field.name);
    }
    to_size_ += size;
  }
}

void RecordMap::copy(const std::uint8_t* from, std::uint8_t* to) const {
  if (!missing_.empty()) std::memset(to, 0, to_size_);
  runs_.copy(from, to);
}

}  // namespace cloud_colorizer
