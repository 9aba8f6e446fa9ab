// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause
#include "pcd.hpp"

namespace cloud_colorizer {

namespace {

char pcdType(FieldType type) {
  switch (type) {
    case FieldType::kInt8:
    case FieldType::kInt16:
    case FieldType::kInt32:
      return 'I';
    case FieldType::kUint8:
    case FieldType::kUint16:
    case FieldType::kUint32:
      return 'U';
    default:
      return 'F';
  }
}

}  // namespace

std::string pcdHeader(const std::vector<Field>& fields, bool double_positions, std::uint64_t num_points) {
  const FieldType position = double_positions ? FieldType::kFloat64 : FieldType::kFloat32;
  std::vector<Field> all{{"x", position}, {"y", position}, {"z", position}};
  all.insert(all.end(), fields.begin(), fields.end());
  std::string names = "FIELDS", sizes = "SIZE", types = "TYPE", counts = "COUNT";
  for (const auto& field : all) {
    names += ' ' + field.name;
    sizes += ' ' + std::to_string(sizeOf(field.type));
    types += std::string(" ") + pcdType(field.type);
    counts += ' ' + std::to_string(field.count);
  }
  auto number = std::to_string(num_points);
  if (number.size() < 10) number.insert(0, 10 - number.size(), '0');
  return "# .PCD v0.7 - Point Cloud Data file format\nVERSION 0.7\n" + names + '\n' + sizes + '\n' + types + '\n' +
         counts + "\nWIDTH " + number + "\nHEIGHT 1\nVIEWPOINT 0 0 0 1 0 0 0\nPOINTS " + number + "\nDATA binary\n";
}

}  // namespace cloud_colorizer
