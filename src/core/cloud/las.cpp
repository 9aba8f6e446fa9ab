// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause
#include "cloud/las.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <limits>
#include <map>
#include <set>

#include "cloud/las_layout.hpp"
#include "cloud_colorizer/base/check.hpp"

namespace cloud_colorizer {
namespace {

template <class T>
T at(const std::vector<char>& bytes, std::size_t offset) {
  T value{};
  std::memcpy(&value, bytes.data() + offset, sizeof(T));
  return value;
}

std::string textAt(const std::vector<char>& bytes, std::size_t offset, std::size_t size) {
  std::string text(bytes.data() + offset, size);
  text.resize(std::min(text.size(), text.find('\0')));
  std::replace_if(
      text.begin(), text.end(), [](unsigned char c) { return c <= ' '; }, '_');
  return text;
}

/// The fields of a record "extra bytes", in their order.
std::vector<PlacedField> extraFields(const std::vector<char>& record, std::set<std::string>& names) {
  std::vector<PlacedField> fields;
  for (std::size_t i = 0; (i + 1) * kLasExtraSize <= record.size(); ++i) {
    const auto code = at<std::uint8_t>(record, i * kLasExtraSize + 2);
    std::string name = textAt(record, i * kLasExtraSize + 4, 32);
    if (code == 0 || code > 30) {  // bytes that nobody describes
      const auto size = at<std::uint8_t>(record, i * kLasExtraSize + 3);
      if (size > 0) fields.push_back({{"_", FieldType::kUint8, size}, Wide::kNo, 0});
      continue;
    }
    if (name.empty()) name = "extra";
    while (!names.insert(name).second) name += '_';
    const LasExtraType& type = kLasExtraTypes.at((code - 1U) % 10U);
    fields.push_back({{name, type.type, 1U + (code - 1U) / 10U}, type.wide, 0});
  }
  return fields;
}

/// GeoTIFF's keys, of which one tells the code: of a projection, or where there is none of a geographic system, and of
/// the heights. Empty where the system is described without a code.
std::string codeOfGeoKeys(const std::vector<char>& record) {
  constexpr std::uint16_t kGeographic = 2048, kProjected = 3072, kVertical = 4096, kUserDefined = 32767;
  std::map<std::uint16_t, std::uint16_t> values;
  for (std::size_t key = 8; key + 8 <= record.size(); key += 8) {
    const auto is_here = at<std::uint16_t>(record, key + 2) == 0;
    const auto value = at<std::uint16_t>(record, key + 6);
    if (is_here && value > 0 && value < kUserDefined) values[at<std::uint16_t>(record, key)] = value;
  }
  const auto system = values.count(kProjected) != 0 ? values.find(kProjected) : values.find(kGeographic);
  if (system == values.end()) return {};
  std::string code = "EPSG:" + std::to_string(system->second);
  if (values.count(kVertical) != 0) code += '+' + std::to_string(values[kVertical]);
  return code;
}

/// What the variable length records tell.
struct Records {
  std::vector<char> extra_bytes;
  std::string crs;  ///< the well-known text before the code
};

Records readRecords(BlockReader& input, std::uint32_t num_records) {
  constexpr std::uint16_t kGeoKeys = 34735, kText = 2112;
  Records records;
  std::string code;
  for (std::uint32_t i = 0; i < num_records; ++i) {
    std::vector<char> head(kLasRecordHead);
    input.read(head.data(), head.size());
    const std::string user = textAt(head, 2, 16);
    const auto id = at<std::uint16_t>(head, 18);
    std::vector<char> content(at<std::uint16_t>(head, 20));
    input.read(content.data(), content.size());
    if (user == "LASF_Spec" && id == 4) {
      records.extra_bytes = std::move(content);
    } else if (user == "LASF_Projection" && id == kGeoKeys) {
      code = codeOfGeoKeys(content);
    } else if (user == "LASF_Projection" && id == kText) {
      records.crs.assign(content.begin(), std::find(content.begin(), content.end(), '\0'));
    }
  }
  if (records.crs.empty()) records.crs = code;
  return records;
}

}  // namespace

std::string remedyOfLaz(const std::string& path) {
  return "; convert it: laszip -i " + path + " -o cloud.las, or pdal translate " + path + " cloud.las";
}

CloudHeader readLasHeader(BlockReader& input) {
  const std::string& path = input.path();
  constexpr std::size_t kOldHeader = 227;
  const std::uint64_t file_size = input.remaining();
  std::vector<char> head(kOldHeader);
  require(file_size >= kOldHeader, path, " is truncated: a LAS file has a header of at least ", kOldHeader, " bytes");
  input.read(head.data(), head.size());
  require(std::string(head.data(), 4) == "LASF", path, " is no LAS file: it does not begin with `LASF`");
  const auto header_size = at<std::uint16_t>(head, 94);
  const auto points_at = at<std::uint32_t>(head, 96);
  const auto format_byte = at<std::uint8_t>(head, 104);
  const auto stride = at<std::uint16_t>(head, 105);
  require((format_byte & 0xC0U) == 0, path, " is compressed (LAZ), which this program does not read",
          remedyOfLaz(path));
  require(format_byte <= 10, path, ": the point format ", static_cast<int>(format_byte),
          " is unknown; 0 to 10 are known");
  require(header_size >= kOldHeader && header_size <= file_size && points_at >= header_size && points_at <= file_size,
          path, " is truncated or damaged: its header has ", header_size, " bytes and its points begin at byte ",
          points_at, " of ", file_size);
  head.resize(header_size);
  input.read(head.data() + kOldHeader, header_size - kOldHeader);

  CloudHeader header;
  header.num_points = at<std::uint32_t>(head, 107);
  if (header_size >= kLasHeaderSize && at<std::uint64_t>(head, 247) > 0)
    header.num_points = at<std::uint64_t>(head, 247);
  const LasPointFormat format = lasPointFormat(format_byte);
  require(stride >= format.size, path, ": a point of ", stride, " bytes is less than the ", format.size,
          " of its point format ", static_cast<int>(format_byte));
  std::set<std::string> names;
  std::size_t end = 0;
  const auto pad = [&](std::size_t to) {
    if (to > end)
      header.fields.push_back({{"_", FieldType::kUint8, static_cast<std::uint32_t>(to - end)}, Wide::kNo, 0});
    end = to;
  };
  for (const LasSlot& slot : format.slots) {
    pad(slot.offset);
    header.fields.push_back({{slot.name, slot.type, 1}, Wide::kNo, 0});
    names.insert(slot.name);
    end += sizeOf(slot.type);
  }
  pad(format.size);
  const Records records = readRecords(input, at<std::uint32_t>(head, 100));
  header.crs = records.crs;
  for (const PlacedField& field : extraFields(records.extra_bytes, names)) {
    const std::size_t size = sizeOf(field.field.type) * field.field.count;
    if (end + size > stride) break;  // described, but not there
    header.fields.push_back(field);
    end += size;
  }
  pad(stride);
  const auto number = [&](std::size_t offset) {
    const double value = at<double>(head, offset);
    require(std::isfinite(value), path, " is damaged: the scale or offset in its header is not finite");
    return value;
  };
  for (int axis = 0; axis < 3; ++axis) {
    header.map_from_points.matrix()(axis, axis) = number(131 + 8 * static_cast<std::size_t>(axis));
    header.map_from_points.matrix()(axis, 3) = number(155 + 8 * static_cast<std::size_t>(axis));
  }
  const std::uint64_t here = file_size - input.remaining();
  require(points_at >= here, path, " is damaged: its points begin within its records");
  input.skip(points_at - here);
  return header;
}

}  // namespace cloud_colorizer
