// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause
#include "cloud/las_layout.hpp"

namespace cloud_colorizer {
namespace {

void addColors(LasPointFormat& format) {
  format.colors = format.size;
  for (const char* name : {"red", "green", "blue"}) {
    format.slots.push_back({name, FieldType::kUint16, format.size});
    format.size += 2;
  }
}

}  // namespace

LasPointFormat lasPointFormat(int number) {
  LasPointFormat format;
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

}  // namespace cloud_colorizer
