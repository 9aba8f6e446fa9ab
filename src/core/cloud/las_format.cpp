// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>

#include "cloud/las.hpp"
#include "cloud/las_layout.hpp"
#include "cloud_colorizer/base/check.hpp"

namespace cloud_colorizer {
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
  for (std::size_t i = 0; i < kLasExtraTypes.size(); ++i) {
    if (kLasExtraTypes.at(i).type == type && kLasExtraTypes.at(i).wide == Wide::kNo)
      return static_cast<std::uint8_t>(i + 1);
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
  const std::vector<Field> extra = placeFields(fields);
  const double extent = box.isEmpty() ? 1
                                      : std::max(1e-9, std::max((box.max() - offset).cwiseAbs().maxCoeff(),
                                                                (box.min() - offset).cwiseAbs().maxCoeff()));
  step_ = std::pow(10.0, std::ceil(std::log10(extent)) - 8);
  require<std::invalid_argument>(crs.size() < 0xFFFF, "the coordinate reference system has ", crs.size(),
                                 " bytes, more than LAS can hold");
  makeHeader(num_points, box, extra, crs);
}

/// Returns the fields that become extra bytes.
std::vector<Field> LasFormat::placeFields(const std::vector<Field>& fields) {
  const bool has_time = std::any_of(fields.begin(), fields.end(), [](const Field& field) {
    return field.name == "gps_time" && field.type == FieldType::kFloat64 && field.count == 1;
  });
  number_ = has_time ? 7 : 2;
  const LasPointFormat format = lasPointFormat(number_);
  flags_ = has_time ? 0x11 : 0x09;
  size_ = format.size;
  std::vector<Field> extra;
  std::size_t from = 0;
  for (const Field& field : fields) {
    const std::size_t size = sizeOf(field.type);
    // The places of the colours are for rgb; those of both formats are the last.
    const auto slot = std::find_if(format.slots.begin(), format.slots.end(), [&](const LasSlot& s) {
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
  require<std::invalid_argument>(extra.size() * kLasExtraSize <= 0xFFFF && size_ <= 0xFFFF, "a point of ", extra.size(),
                                 " further fields is more than LAS can hold; save as .ply");
  return extra;
}

void LasFormat::makeHeader(std::uint64_t num_points, const Eigen::AlignedBox3d& box, const std::vector<Field>& extra,
                           const std::string& crs) {
  const bool has_time = number_ >= 6;  // of formats from 6 on
  const std::size_t crs_at = kLasHeaderSize + (extra.empty() ? 0 : kLasRecordHead + extra.size() * kLasExtraSize);
  const std::size_t points_at = crs_at + (crs.empty() ? 0 : kLasRecordHead + crs.size() + 1);
  HeaderBytes bytes(points_at);
  bytes.put(0, std::string("LASF"));
  bytes.put<std::uint16_t>(6, has_time || !crs.empty() ? 0x10 : 0);  // as WKT, if any, and always in formats from 6 on
  bytes.put<std::uint8_t>(24, 1);
  bytes.put<std::uint8_t>(25, 4);
  bytes.put(26, std::string("cloud_colorizer"));
  bytes.put(58, std::string("cloud_colorizer"));
  bytes.put<std::uint16_t>(94, kLasHeaderSize);
  bytes.put<std::uint32_t>(96, static_cast<std::uint32_t>(points_at));
  bytes.put<std::uint32_t>(100, (extra.empty() ? 0U : 1U) + (crs.empty() ? 0U : 1U));
  bytes.put<std::uint8_t>(104, static_cast<std::uint8_t>(number_));
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
    beginRecord(bytes, kLasHeaderSize, {"LASF_Spec", 4, extra.size() * kLasExtraSize, "extra bytes"});
    for (std::size_t i = 0; i < extra.size(); ++i)
      describeExtra(bytes, kLasHeaderSize + kLasRecordHead + i * kLasExtraSize, extra[i]);
  }
  if (!crs.empty()) {
    beginRecord(bytes, crs_at, {"LASF_Projection", 2112, crs.size() + 1, "OGC WKT"});
    bytes.put(crs_at + kLasRecordHead, crs);
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
    target[kLasReturnFlags] = flags_;
    runs_.copy(record, target);
  }
}

}  // namespace cloud_colorizer
