// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause
#include "cloud/pcd.hpp"

#include <cmath>
#include <map>

#include "base/text.hpp"
#include "cloud_colorizer/base/check.hpp"

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

PlacedField pcdField(const std::string& name, const std::string& type, const std::string& size,
                     const std::string& count, const std::string& path) {
  static const std::map<std::string, FieldType> kTypes{
      {"I1", FieldType::kInt8},    {"I2", FieldType::kInt16},  {"I4", FieldType::kInt32},   {"U1", FieldType::kUint8},
      {"U2", FieldType::kUint16},  {"U4", FieldType::kUint32}, {"F4", FieldType::kFloat32}, {"F8", FieldType::kFloat64},
      {"I8", FieldType::kFloat64}, {"U8", FieldType::kFloat64}};
  const auto found = kTypes.find(type + size);
  long long number = 0;
  require(found != kTypes.end(), path, ": the field ", name, " has the unknown TYPE ", type, " with SIZE ", size);
  require(parseInteger(count, number) && number > 0 && number <= 0xFFFFFFFF, path, ": the field ", name,
          " has the COUNT ", count, ", which must be at least 1");
  const auto wide = found->first == "I8" ? Wide::kInt64 : found->first == "U8" ? Wide::kUint64 : Wide::kNo;
  return {{name, found->second, static_cast<std::uint32_t>(number)}, wide, 0};
}

using Entries = std::map<std::string, std::vector<std::string>>;

std::uint64_t pcdNumber(const Entries& entries, const std::string& key, const std::string& path) {
  const auto found = entries.find(key);
  long long number = 0;
  require(found != entries.end() && found->second.size() == 1 && parseInteger(found->second[0], number) &&
              number >= 0 && number <= 0xFFFFFFFFFF,
          path, ": ", key, " in its header is missing or no count");
  return static_cast<std::uint64_t>(number);
}

/// The lines of the header up to DATA, by their first word.
Entries readEntries(BlockReader& input) {
  Entries entries;
  std::string line;
  input.startText();
  while (entries.count("DATA") == 0) {
    require(input.readLine(line), input.path(), " is no PCD file, or truncated: its header has no DATA line");
    auto words = splitWords(line);
    if (words.empty() || words[0][0] == '#') continue;
    const auto key = words[0] == "COLUMNS" ? "FIELDS" : words[0];
    require(entries.count(key) == 0, input.path(), ": ", key.substr(0, 80), " is there twice in its header");
    words.erase(words.begin());
    entries[key] = std::move(words);
  }
  return entries;
}

/// VIEWPOINT tx ty tz qw qx qy qz: the pose of the scanner, in whose frame the points are.
Eigen::Isometry3d pcdViewpoint(const std::vector<std::string>& words, const std::string& path) {
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
  if (words.empty()) return pose;
  double v[7] = {};
  bool is_good = words.size() == 7;
  for (std::size_t i = 0; i < 7 && is_good; ++i) is_good = parseDouble(words[i], v[i]) && std::isfinite(v[i]);
  const Eigen::Quaterniond rotation(v[3], v[4], v[5], v[6]);
  require(is_good && std::abs(rotation.norm() - 1) < 0.01, path,
          ": VIEWPOINT in its header must be tx ty tz qw qx qy qz, with a quaternion of norm 1");
  if (v[3] != 1) pose.linear() = rotation.normalized().toRotationMatrix();
  pose.translation() = Eigen::Vector3d(v[0], v[1], v[2]);
  return pose;
}

}  // namespace

CloudHeader readPcdHeader(BlockReader& input) {
  const auto entries = readEntries(input);
  const auto& path = input.path();
  const auto list = [&](const std::string& key) {
    const auto found = entries.find(key);
    return found == entries.end() ? std::vector<std::string>{} : found->second;
  };
  const auto names = list("FIELDS"), sizes = list("SIZE"), types = list("TYPE");
  auto counts = list("COUNT");
  if (counts.empty()) counts.assign(names.size(), "1");
  require(
      !names.empty() && sizes.size() == names.size() && types.size() == names.size() && counts.size() == names.size(),
      path, ": FIELDS, SIZE, TYPE and COUNT in its header must have one entry a field");
  CloudHeader header;
  for (std::size_t i = 0; i < names.size(); ++i) {
    header.fields.push_back(pcdField(names[i], types[i], sizes[i], counts[i], path));
  }
  // Versions before 0.7 have no HEIGHT, the first ones POINTS alone.
  const char* const width_key = entries.count("WIDTH") > 0 ? "WIDTH" : "POINTS";
  const auto width = pcdNumber(entries, width_key, path);
  const auto height = entries.count("HEIGHT") > 0 ? pcdNumber(entries, "HEIGHT", path) : 1;
  require(width == 0 || height <= 0xFFFFFFFFFF / width, path, ": WIDTH ", width, " x HEIGHT ", height,
          " is more than any file holds");
  header.num_points = width * height;
  if (entries.count("POINTS") > 0) {
    const auto points = pcdNumber(entries, "POINTS", path);
    require(points == header.num_points, path, ": POINTS ", points, " is not WIDTH ", width, " x HEIGHT ", height,
            "; correct the header by what the file holds");
  }
  header.map_from_points = pcdViewpoint(list("VIEWPOINT"), path);
  const auto data = list("DATA");
  const auto encoding = data.empty() ? "" : data[0];
  require(encoding == "ascii" || encoding == "binary" || encoding == "binary_compressed", path, ": DATA ", encoding,
          " is unknown; it must be ascii, binary or binary_compressed");
  header.encoding = encoding == "ascii"    ? Encoding::kAscii
                    : encoding == "binary" ? Encoding::kBinary
                                           : Encoding::kCompressed;
  return header;
}

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
