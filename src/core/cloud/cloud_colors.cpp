// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause
#include "cloud/cloud_colors.hpp"

#include <cmath>

#include "cloud_colorizer/base/check.hpp"

namespace cloud_colorizer {

CloudColors::CloudColors(const std::vector<Field>& fields, const std::string& source) {
  // A cloud may have come with red, green and blue of its own beside the rgb that it was given later.
  std::string known;
  for (const auto& field : fields) known += " " + field.name;
  for (const char* name : {"rgb", "rgba"}) {
    const auto packed = findField(fields, name);
    if (!packed || !offsets_.empty()) continue;
    require(sizeOf(packed->field.type) == 4, source, ": field ", name, " must have 4 bytes");
    offsets_ = {packed->offset};
  }
  if (!offsets_.empty()) return;
  for (const char* name : {"red", "green", "blue"}) {
    const auto channel = findField(fields, name);
    require(channel.has_value(), source,
            ": the cloud has no colours (no field rgb or rgba, and not red, green and blue); ",
            "its fields are:", known);
    require(offsets_.empty() || channel->field.type == type_, source, ": fields red and ", name, " differ in type");
    type_ = channel->field.type;
    offsets_.push_back(channel->offset);
  }
}

Values CloudColors::read(const Cloud& cloud) const {
  const std::size_t size = recordSize(cloud.fields);
  Values colors(3, cloud.positions.cols());
  for (Eigen::Index p = 0; p < colors.cols(); ++p) {
    const std::uint8_t* record = cloud.records.data() + static_cast<std::size_t>(p) * size;
    std::uint32_t packed = 0;
    if (offsets_.size() == 1) std::memcpy(&packed, record + offsets_[0], sizeof packed);
    for (std::size_t c = 0; c < 3; ++c) {
      const double number =
          offsets_.size() == 1 ? packed >> (16 - 8 * c) & 0xffU : numberAt(record + offsets_[c], type_);
      colors(static_cast<Eigen::Index>(c), p) = std::isfinite(number) ? static_cast<float>(number) : 0;
    }
  }
  return colors;
}

float CloudColors::scale(float largest) const {
  if ((type_ == FieldType::kFloat32 || type_ == FieldType::kFloat64) && largest <= 1) return 255;
  if ((type_ == FieldType::kInt16 || type_ == FieldType::kUint16) && largest > 255) return 1 / 257.F;
  return 1;
}

std::string CloudColors::describe(float largest) const {
  const float factor = scale(largest);
  if (factor == 1) return "";
  return factor > 1 ? "its colours are numbers up to 1: taken as 0 to 1"
                    : "its colours are numbers of 16 bits above 255: taken as 0 to 65535";
}

}  // namespace cloud_colorizer
