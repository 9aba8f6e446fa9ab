// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause
#include "cloud/ply.hpp"

#include <algorithm>
#include <array>
#include <cstring>

#include "base/text.hpp"
#include "cloud_colorizer/base/check.hpp"

namespace cloud_colorizer {

namespace {

struct PlyProperty {
  FileField value;
  bool is_list = false;
  FieldType length_type = FieldType::kUint8;  ///< of a list
};

struct PlyElement {
  std::string name;
  std::uint64_t count = 0;
  std::vector<PlyProperty> properties;
};

FieldType plyType(const std::string& name, const std::string& where) {
  constexpr std::array<const char*, 8> kNames{"char", "uchar", "short", "ushort", "int", "uint", "float", "double"};
  constexpr std::array<const char*, 8> kAliases{"int8",  "uint8",  "int16",   "uint16",
                                                "int32", "uint32", "float32", "float64"};
  for (std::size_t i = 0; i < kNames.size(); ++i) {
    if (name == kNames[i] || name == kAliases[i]) return static_cast<FieldType>(i + 1);
  }
  throw std::runtime_error(where + ": the property type \"" + name + "\" is unknown");
}

std::uint64_t parseCount(const std::string& word, const std::string& where) {
  long long count = 0;
  require(parseInteger(word, count) && count >= 0, where, ": \"", word, "\" is no count");
  return static_cast<std::uint64_t>(count);
}

Encoding plyEncoding(const std::string& name, const std::string& where) {
  if (name == "ascii") return Encoding::kAscii;
  if (name == "binary_little_endian") return Encoding::kBinary;
  require(name == "binary_big_endian", where, ": the format \"", name,
          "\" is unknown; it must be ascii, binary_little_endian or binary_big_endian");
  return Encoding::kBinaryBigEndian;
}

PlyProperty parseProperty(const std::vector<std::string>& words, const std::string& where) {
  PlyProperty property;
  property.is_list = words.size() == 5 && words[1] == "list";
  require(property.is_list || words.size() == 3, where, ": a property is `property TYPE NAME`");
  property.value.field = {words.back(), plyType(words[words.size() - 2], where), 1};
  if (property.is_list) property.length_type = plyType(words[2], where);
  return property;
}

std::uint64_t readListLength(BlockReader& input, FieldType type, bool swap) {
  std::array<std::uint8_t, 8> bytes{};
  const auto size = sizeOf(type);
  input.read(bytes.data(), size);
  if (swap) std::reverse(bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(size));
  require(type != FieldType::kFloat32 && type != FieldType::kFloat64, input.path(), ": a list's length is no integer");
  std::uint64_t length = 0;
  std::memcpy(&length, bytes.data(), size);
  return length;
}

/// Moves behind an element that lies before the points.
void skipElement(BlockReader& input, const PlyElement& element, Encoding encoding) {
  std::uint64_t fixed_size = 0;
  bool has_list = false;
  for (const auto& property : element.properties) {
    fixed_size += sizeOf(property.value.field.type);
    has_list = has_list || property.is_list;
  }
  if (encoding != Encoding::kAscii && !has_list) {
    require(fixed_size == 0 || element.count <= input.remaining() / fixed_size, input.path(),
            " is truncated: the element ", element.name, " is not whole");
    input.skip(element.count * fixed_size);
    return;
  }
  std::string line;
  for (std::uint64_t i = 0; i < element.count; ++i) {
    if (encoding == Encoding::kAscii) {
      require(input.readLine(line), input.path(), " is truncated: the element ", element.name, " is not whole");
      continue;
    }
    for (const auto& property : element.properties) {
      const auto count =
          property.is_list ? readListLength(input, property.length_type, encoding == Encoding::kBinaryBigEndian) : 1;
      input.skip(count * sizeOf(property.value.field.type));
    }
  }
}

}  // namespace

CloudHeader readPlyHeader(BlockReader& input) {
  CloudHeader header;
  std::vector<PlyElement> elements;
  std::string line;
  bool has_format = false;
  require(input.readLine(line) && line == "ply", input.path(), " is no PLY file: it does not begin with `ply`");
  for (std::size_t number = 2;; ++number) {
    require(input.readLine(line), input.path(), " is truncated: its header has no end_header");
    const auto where = input.path() + " line " + std::to_string(number);
    const auto words = splitWords(line);
    if (words.empty() || words[0] == "comment" || words[0] == "obj_info") continue;
    if (words[0] == "end_header") break;
    if (words[0] == "format" && words.size() >= 2) {
      header.encoding = plyEncoding(words[1], where);
      has_format = true;
    } else if (words[0] == "element" && words.size() == 3) {
      elements.push_back({words[1], parseCount(words[2], where), {}});
    } else {
      require(words[0] == "property" && !elements.empty(), where, ": `", line.substr(0, 80), "` is no PLY header line");
      elements.back().properties.push_back(parseProperty(words, where));
    }
  }
  require(has_format, input.path(), " has no format line in its header");
  const auto vertex =
      std::find_if(elements.begin(), elements.end(), [](const PlyElement& e) { return e.name == "vertex"; });
  require(vertex != elements.end(), input.path(), " has no points: it has no element vertex");
  for (auto element = elements.begin(); element != vertex; ++element) skipElement(input, *element, header.encoding);
  header.num_points = vertex->count;
  for (const auto& property : vertex->properties) {
    require(!property.is_list, input.path(), ": the list property ", property.value.field.name,
            " of the element vertex cannot be read; write the points without it");
    header.fields.push_back(property.value);
  }
  return header;
}

}  // namespace cloud_colorizer
