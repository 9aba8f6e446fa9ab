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

constexpr std::array<const char*, 8> kTypeNames{"char", "uchar", "short", "ushort", "int", "uint", "float", "double"};

struct PlyProperty {
  PlacedField value;
  bool is_list = false;
  FieldType length_type = FieldType::kUint8;  ///< of a list
};

struct PlyElement {
  std::string name;
  std::uint64_t count = 0;
  std::vector<PlyProperty> properties;
};

bool isWide(const std::string& name) {
  return name == "int64" || name == "uint64" || name == "longlong" || name == "ulonglong";
}

FieldType plyType(const std::string& name, const std::string& where) {
  if (isWide(name)) return FieldType::kFloat64;  // as it is read
  for (std::size_t i = 0; i < kTypeNames.size(); ++i) {
    const auto type = static_cast<FieldType>(i + 1);
    if (name == kTypeNames[i] || name == toString(type)) return type;
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
  const std::string& type = words[words.size() - 2];
  property.value.field = {words.back(), plyType(type, where), 1};
  if (isWide(type)) property.value.wide = type[0] == 'u' ? Wide::kUint64 : Wide::kInt64;
  if (property.is_list) property.length_type = plyType(words[2], where);
  return property;
}

double readPlyNumber(BlockReader& input, FieldType type, Encoding encoding) {
  std::array<std::uint8_t, 8> bytes{};
  const auto size = sizeOf(type);
  input.read(bytes.data(), size);
  if (encoding == Encoding::kBinaryBigEndian) std::reverse(bytes.begin(), bytes.begin() + static_cast<long>(size));
  return numberAt(bytes.data(), type);
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
      const auto count = property.is_list ? readListLength(input, property.length_type, encoding) : 1;
      input.skip(count * sizeOf(property.value.field.type));
    }
  }
}

bool isPackedColor(const Field& field) {
  return field.name == "rgb" && field.count == 1 &&
         (field.type == FieldType::kFloat32 || field.type == FieldType::kUint32);
}

/// Properties of a PLY after x, y, z. Arrays become name_0, name_1, ...; rgb becomes red, green, blue, and fields that
/// have these names already get the prefix "input_".
std::vector<Field> plyFields(const std::vector<Field>& fields) {
  const bool has_color = std::any_of(fields.begin(), fields.end(), isPackedColor);
  std::vector<Field> result;
  for (const auto& field : fields) {
    const bool clashes = has_color && (field.name == "red" || field.name == "green" || field.name == "blue");
    if (isPackedColor(field)) {
      for (const char* name : {"red", "green", "blue"}) result.push_back({name, FieldType::kUint8});
    } else if (field.count == 1) {
      result.push_back({(clashes ? "input_" : "") + field.name, field.type});
    } else {
      for (std::uint32_t i = 0; i < field.count; ++i) {
        result.push_back({field.name + '_' + std::to_string(i), field.type});
      }
    }
  }
  checkFields(result);
  return result;
}

std::vector<PlyElement> readElements(BlockReader& input, Encoding& encoding) {
  std::vector<PlyElement> elements;
  std::string line;
  bool has_format = false;
  input.startText();
  require(input.readLine(line) && line == "ply", input.path(), " is no PLY file: it does not begin with `ply`");
  for (std::size_t number = 2;; ++number) {
    require(input.readLine(line), input.path(), " is truncated: its header has no end_header");
    const auto where = input.path() + " line " + std::to_string(number);
    const auto words = splitWords(line);
    if (words.empty() || words[0] == "comment" || words[0] == "obj_info") continue;
    if (words[0] == "end_header") break;
    if (words[0] == "format" && words.size() >= 2) {
      encoding = plyEncoding(words[1], where);
      has_format = true;
    } else if (words[0] == "element" && words.size() == 3) {
      elements.push_back({words[1], parseCount(words[2], where), {}});
    } else {
      require(words[0] == "property" && !elements.empty(), where, ": `", line.substr(0, 80), "` is no PLY header line");
      elements.back().properties.push_back(parseProperty(words, where));
    }
  }
  require(has_format, input.path(), " has no format line in its header");
  return elements;
}

/// The list of corners in one face; what else it has is passed over.
std::vector<double> readCorners(BlockReader& input, const PlyElement& element, Encoding encoding, std::string& line) {
  std::vector<double> corners;
  const bool is_text = encoding == Encoding::kAscii;
  require(!is_text || input.readLine(line), input.path(), " is truncated: it ends within its faces");
  const char* text = line.c_str();
  const auto next = [&](FieldType type) {
    double number = 0;
    if (!is_text) return readPlyNumber(input, type, encoding);
    require(parseDouble(text, number), input.path(), ": `", line.substr(0, 80), "` is no face");
    return number;
  };
  for (const auto& property : element.properties) {
    const bool wanted = property.is_list && property.value.field.name.rfind("vertex_ind", 0) == 0;
    const double count = property.is_list ? next(property.length_type) : 1;
    for (double i = 0; i < count; ++i) {
      const double number = next(property.value.field.type);
      if (wanted) corners.push_back(number);
    }
  }
  return corners;
}

}  // namespace

std::uint64_t readListLength(BlockReader& input, FieldType type, Encoding encoding) {
  require(type != FieldType::kFloat32 && type != FieldType::kFloat64, input.path(), ": a list's length is no integer");
  const double length = readPlyNumber(input, type, encoding);
  require(length >= 0, input.path(), ": a list has the length ", length);
  return static_cast<std::uint64_t>(length);
}

CloudHeader readPlyHeader(BlockReader& input) {
  CloudHeader header;
  const std::vector<PlyElement> elements = readElements(input, header.encoding);
  const auto vertex =
      std::find_if(elements.begin(), elements.end(), [](const PlyElement& e) { return e.name == "vertex"; });
  require(vertex != elements.end(), input.path(), " has no points: it has no element vertex");
  for (auto element = elements.begin(); element != vertex; ++element) skipElement(input, *element, header.encoding);
  header.num_points = vertex->count;
  for (const auto& property : vertex->properties) {
    if (property.is_list) {
      header.lists.push_back({header.fields.size(), property.length_type, sizeOf(property.value.field.type)});
    } else {
      header.fields.push_back(property.value);
    }
  }
  return header;
}

std::vector<Eigen::Vector3i> readPlyFaces(const std::string& path) {
  BlockReader input(path);
  Encoding encoding = Encoding::kAscii;
  std::vector<Eigen::Vector3i> faces;
  double num_points = 0;
  std::string line;
  for (const PlyElement& element : readElements(input, encoding)) {
    if (element.name == "vertex") num_points = static_cast<double>(element.count);
    if (element.name != "face") {
      skipElement(input, element, encoding);
      continue;
    }
    require(element.count <= input.remaining(), path, " is truncated: it cannot hold ", element.count, " faces");
    for (std::uint64_t f = 0; f < element.count; ++f) {
      const std::vector<double> corners = readCorners(input, element, encoding, line);
      for (const double corner : corners) {
        require(corner >= 0 && corner < num_points, path, ": face ", f, " has a vertex index outside [0, ", num_points,
                ")");
      }
      for (std::size_t c = 2; c < corners.size(); ++c) {
        faces.push_back(Eigen::Vector3d(corners[0], corners[c - 1], corners[c]).cast<int>());
      }
    }
    break;
  }
  return faces;
}

std::string plyHeader(const std::vector<Field>& fields, bool double_positions, std::uint64_t num_points) {
  const auto position = double_positions ? FieldType::kFloat64 : FieldType::kFloat32;
  std::vector<Field> properties{{"x", position}, {"y", position}, {"z", position}};
  const auto others = plyFields(fields);
  properties.insert(properties.end(), others.begin(), others.end());
  std::string header = "ply\nformat binary_little_endian 1.0\ncomment cloud_colorizer\nelement vertex " +
                       std::to_string(num_points) + '\n';
  for (const auto& field : properties) {
    header += std::string("property ") + kTypeNames[static_cast<std::size_t>(field.type) - 1] + ' ' + field.name + '\n';
  }
  return header + "end_header\n";
}

PackedFormat plyFormat(const std::vector<Field>& fields, bool double_positions) {
  PackedFormat format{double_positions, {}, 0};
  std::size_t from = 0;
  for (const auto& field : fields) {
    const auto size = sizeOf(field.type) * field.count;
    auto& to = format.record_size;
    if (isPackedColor(field)) {  // 0x00RRGGBB, little endian
      for (const std::size_t byte : {2, 1, 0}) format.runs.add(from + byte, to++, 1);
    } else {
      format.runs.add(from, to, size);
      to += size;
    }
    from += size;
  }
  return format;
}

}  // namespace cloud_colorizer
