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

#include "cloud_colorizer/base/check.hpp"

namespace cloud_colorizer {
namespace {

constexpr std::size_t kHeaderSize = 375;  // bytes, of version 1.4
constexpr std::size_t kVlrSize = 54;      // bytes before what a variable length record holds
constexpr std::size_t kExtraSize = 192;   // bytes that describe one field of extra bytes
constexpr std::size_t kReturnFlags = 14;  // offset in a point of any format

struct Slot {
  const char* name;
  FieldType type;
  std::size_t offset;
};
/// Where the fields of a point format lie, x, y and z first.
struct PointFormat {
  std::vector<Slot> slots;
  std::size_t colors = 0;  ///< offset of red, green and blue; 0: it has none
  std::size_t size = 0;
};

void addColors(PointFormat& format) {
  format.colors = format.size;
  for (const char* name : {"red", "green", "blue"}) {
    format.slots.push_back({name, FieldType::kUint16, format.size});
    format.size += 2;
  }
}

/// Table of the specification: formats 0 to 5 have 20 bytes, 6 to 10 have 30, then time, colours and waves.
PointFormat pointFormat(int number) {
  PointFormat format;
  format.slots = {{"x", FieldType::kInt32, 0},
                  {"y", FieldType::kInt32, 4},
                  {"z", FieldType::kInt32, 8},
                  {"intensity", FieldType::kUint16, 12}};
  const auto add = [&](const char* name, FieldType type, std::size_t offset) {
    format.slots.push_back({name, type, offset});
  };
  if (number < 6) {
    add("classification", FieldType::kUint8, 15);
    add("scan_angle", FieldType::kInt8, 16);
    add("user_data", FieldType::kUint8, 17);
    add("point_source_id", FieldType::kUint16, 18);
    format.size = 20;
    if (number == 1 || number >= 3) {
      add("gps_time", FieldType::kFloat64, 20);
      format.size = 28;
    }
    if (number == 2 || number == 3 || number == 5) addColors(format);
    if (number >= 4) format.size += 29;
  } else {
    add("classification", FieldType::kUint8, 16);
    add("user_data", FieldType::kUint8, 17);
    add("scan_angle", FieldType::kInt16, 18);
    add("point_source_id", FieldType::kUint16, 20);
    add("gps_time", FieldType::kFloat64, 22);
    format.size = 30;
    if (number == 7 || number == 8 || number == 10) addColors(format);
    if (number == 8 || number == 10) {
      add("nir", FieldType::kUint16, format.size);
      format.size += 2;
    }
    if (number >= 9) format.size += 29;
  }
  return format;
}

/// Codes 1 to 10 of extra bytes.
struct ExtraType {
  FieldType type;
  Wide wide;
};
constexpr std::array<ExtraType, 10> kExtraTypes = {{{FieldType::kUint8, Wide::kNo},
                                                    {FieldType::kInt8, Wide::kNo},
                                                    {FieldType::kUint16, Wide::kNo},
                                                    {FieldType::kInt16, Wide::kNo},
                                                    {FieldType::kUint32, Wide::kNo},
                                                    {FieldType::kInt32, Wide::kNo},
                                                    {FieldType::kFloat64, Wide::kUint64},
                                                    {FieldType::kFloat64, Wide::kInt64},
                                                    {FieldType::kFloat32, Wide::kNo},
                                                    {FieldType::kFloat64, Wide::kNo}}};

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
  for (std::size_t i = 0; (i + 1) * kExtraSize <= record.size(); ++i) {
    const auto code = at<std::uint8_t>(record, i * kExtraSize + 2);
    std::string name = textAt(record, i * kExtraSize + 4, 32);
    if (code == 0 || code > 30) {  // bytes that nobody describes
      const auto size = at<std::uint8_t>(record, i * kExtraSize + 3);
      if (size > 0) fields.push_back({{"_", FieldType::kUint8, size}, Wide::kNo, 0});
      continue;
    }
    if (name.empty()) name = "extra";
    while (!names.insert(name).second) name += '_';
    const ExtraType& type = kExtraTypes.at((code - 1U) % 10U);
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
    std::vector<char> head(kVlrSize);
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
  if (header_size >= kHeaderSize && at<std::uint64_t>(head, 247) > 0) header.num_points = at<std::uint64_t>(head, 247);
  const PointFormat format = pointFormat(format_byte);
  require(stride >= format.size, path, ": a point of ", stride, " bytes is less than the ", format.size,
          " of its point format ", static_cast<int>(format_byte));
  std::set<std::string> names;
  std::size_t end = 0;
  const auto pad = [&](std::size_t to) {
    if (to > end)
      header.fields.push_back({{"_", FieldType::kUint8, static_cast<std::uint32_t>(to - end)}, Wide::kNo, 0});
    end = to;
  };
  for (const Slot& slot : format.slots) {
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

namespace {

/// Bytes of a header, by their offsets.
class HeaderBytes {
 public:
  explicit HeaderBytes(std::size_t size) : bytes_(size, '\0') {}
  template <class T>
  void put(std::size_t offset, T value) {
    std::memcpy(bytes_.data() + offset, &value, sizeof(T));
  }
  void put(std::size_t offset, const std::string& text) { bytes_.replace(offset, text.size(), text); }
  const std::string& bytes() const { return bytes_; }

 private:
  std::string bytes_;
};

std::uint8_t extraCode(FieldType type) {
  for (std::size_t i = 0; i < kExtraTypes.size(); ++i) {
    if (kExtraTypes.at(i).type == type && kExtraTypes.at(i).wide == Wide::kNo) return static_cast<std::uint8_t>(i + 1);
  }
  return 0;
}

struct RecordHead {
  std::string user;
  std::uint16_t id;
  std::size_t size;  ///< bytes
  std::string description;
};
void beginRecord(HeaderBytes& bytes, std::size_t offset, const RecordHead& head) {
  bytes.put(offset + 2, head.user);
  bytes.put<std::uint16_t>(offset + 18, head.id);
  bytes.put<std::uint16_t>(offset + 20, static_cast<std::uint16_t>(head.size));
  bytes.put(offset + 22, head.description);
}

void describeExtra(HeaderBytes& bytes, std::size_t offset, const Field& field) {
  require<std::invalid_argument>(field.name.size() <= 32, "the field ", field.name,
                                 " has a name of more than 32 bytes, which LAS cannot hold; rename it or save as .ply");
  bytes.put(offset + 2, extraCode(field.type));
  bytes.put(offset + 4, field.name);
}

}  // namespace

LasFormat::LasFormat(const std::vector<Field>& fields, std::uint64_t num_points, const Eigen::AlignedBox3d& box,
                     const Eigen::Vector3d& offset, const std::string& crs)
    : offset_(offset) {
  const bool has_time = std::any_of(fields.begin(), fields.end(), [](const Field& field) {
    return field.name == "gps_time" && field.type == FieldType::kFloat64 && field.count == 1;
  });
  const int number = has_time ? 7 : 2;
  const PointFormat format = pointFormat(number);
  flags_ = has_time ? 0x11 : 0x09;
  size_ = format.size;
  std::vector<Field> extra;
  std::size_t from = 0;
  for (const Field& field : fields) {
    const std::size_t size = sizeOf(field.type);
    // The places of the colours are for rgb; those of both formats are the last.
    const auto slot = std::find_if(format.slots.begin(), format.slots.end(), [&](const Slot& s) {
      return s.name == field.name && s.type == field.type && field.count == 1 && s.offset < format.colors;
    });
    if (field.name == "rgb" && size == 4 && field.count == 1) {  // 0x00RRGGBB, little endian; 257 times each
      for (std::size_t byte = 0; byte < 6; ++byte) runs_.add(from + 2 - byte / 2, format.colors + byte, 1);
    } else if (slot != format.slots.end()) {
      runs_.add(from, slot->offset, size);
    } else {
      for (std::uint32_t i = 0; i < field.count; ++i) {
        extra.push_back({field.count == 1 ? field.name : field.name + '_' + std::to_string(i), field.type, 1});
        runs_.add(from + i * size, size_, size);
        size_ += size;
      }
    }
    from += size * field.count;
  }
  require<std::invalid_argument>(extra.size() * kExtraSize <= 0xFFFF && size_ <= 0xFFFF, "a point of ", extra.size(),
                                 " further fields is more than LAS can hold; save as .ply");

  const double extent = box.isEmpty() ? 1
                                      : std::max(1e-9, std::max((box.max() - offset).cwiseAbs().maxCoeff(),
                                                                (box.min() - offset).cwiseAbs().maxCoeff()));
  step_ = std::pow(10.0, std::ceil(std::log10(extent)) - 8);
  require<std::invalid_argument>(crs.size() < 0xFFFF, "the coordinate reference system has ", crs.size(),
                                 " bytes, more than LAS can hold");
  const std::size_t crs_at = kHeaderSize + (extra.empty() ? 0 : kVlrSize + extra.size() * kExtraSize);
  const std::size_t points_at = crs_at + (crs.empty() ? 0 : kVlrSize + crs.size() + 1);
  HeaderBytes bytes(points_at);
  bytes.put(0, std::string("LASF"));
  bytes.put<std::uint16_t>(6, has_time || !crs.empty() ? 0x10 : 0);  // as WKT, if any, and always in formats from 6 on
  bytes.put<std::uint8_t>(24, 1);
  bytes.put<std::uint8_t>(25, 4);
  bytes.put(26, std::string("cloud_colorizer"));
  bytes.put(58, std::string("cloud_colorizer"));
  bytes.put<std::uint16_t>(94, kHeaderSize);
  bytes.put<std::uint32_t>(96, static_cast<std::uint32_t>(points_at));
  bytes.put<std::uint32_t>(100, (extra.empty() ? 0U : 1U) + (crs.empty() ? 0U : 1U));
  bytes.put<std::uint8_t>(104, static_cast<std::uint8_t>(number));
  bytes.put<std::uint16_t>(105, static_cast<std::uint16_t>(size_));
  const bool has_legacy = !has_time && num_points <= std::numeric_limits<std::uint32_t>::max();
  for (const std::size_t at : {107U, 111U})
    bytes.put<std::uint32_t>(at, has_legacy ? static_cast<std::uint32_t>(num_points) : 0);
  for (int axis = 0; axis < 3; ++axis) {
    const auto a = static_cast<std::size_t>(axis);
    bytes.put<double>(131 + 8 * a, step_);
    bytes.put<double>(155 + 8 * a, offset_[axis]);
    bytes.put<double>(179 + 16 * a, box.isEmpty() ? 0 : box.max()[axis]);
    bytes.put<double>(187 + 16 * a, box.isEmpty() ? 0 : box.min()[axis]);
  }
  for (const std::size_t at : {247U, 255U}) bytes.put<std::uint64_t>(at, num_points);
  if (!extra.empty()) {
    beginRecord(bytes, kHeaderSize, {"LASF_Spec", 4, extra.size() * kExtraSize, "extra bytes"});
    for (std::size_t i = 0; i < extra.size(); ++i)
      describeExtra(bytes, kHeaderSize + kVlrSize + i * kExtraSize, extra[i]);
  }
  if (!crs.empty()) {
    beginRecord(bytes, crs_at, {"LASF_Projection", 2112, crs.size() + 1, "OGC WKT"});
    bytes.put(crs_at + kVlrSize, crs);
  }
  header_ = bytes.bytes();
}

void LasFormat::pack(const Cloud& cloud, std::size_t first, std::size_t num_points, std::uint8_t* target) const {
  constexpr double kMost = std::numeric_limits<std::int32_t>::max();
  const std::size_t source_size = recordSize(cloud.fields);
  std::memset(target, 0, num_points * size_);
  const std::uint8_t* record = cloud.records.data() + first * source_size;
  for (std::size_t i = 0; i < num_points; ++i, record += source_size, target += size_) {
    const Eigen::Vector3d steps = (cloud.positions.col(static_cast<Eigen::Index>(first + i)) - offset_) / step_;
    for (int axis = 0; axis < 3; ++axis) {
      const auto whole = static_cast<std::int32_t>(std::llround(std::clamp(steps[axis], -kMost, kMost)));
      std::memcpy(target + 4 * axis, &whole, sizeof whole);
    }
    target[kReturnFlags] = flags_;
    runs_.copy(record, target);
  }
}

}  // namespace cloud_colorizer
