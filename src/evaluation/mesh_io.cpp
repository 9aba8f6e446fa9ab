// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause

/// Reading of PLY meshes: the header is a list of elements, and values are taken one by one by their types.
#include <cmath>
#include <cstring>
#include <fstream>
#include <map>
#include <sstream>

#include "cloud_colorizer/base/check.hpp"
#include "evaluation/mesh.hpp"

namespace cloud_colorizer {
namespace {

struct Property {
  std::string name, type, count_type;  ///< count_type is empty for a scalar
};

struct Element {
  std::string name;
  std::size_t count = 0;
  std::vector<Property> properties;
};

struct Header {
  bool binary = false;
  std::vector<Element> elements;
};

Header readHeader(std::istream& in, const std::string& path) {
  Header header;
  std::string line, word;
  std::getline(in, line);
  require(line.rfind("ply", 0) == 0, path, ": not a PLY file (it does not begin with 'ply')");
  while (std::getline(in, line)) {
    std::istringstream words(line);
    words >> word;
    if (word == "end_header") return header;
    if (word == "format") {
      words >> word;
      require(word == "ascii" || word == "binary_little_endian", path, ": format '", word,
              "' is not supported for meshes; convert to binary_little_endian or ascii");
      header.binary = word != "ascii";
    } else if (word == "element") {
      Element element;
      words >> element.name >> element.count;
      header.elements.push_back(element);
    } else if (word == "property") {
      require(!header.elements.empty(), path, ": property before the first element: ", line);
      Property property;
      words >> property.type;
      if (property.type == "list") words >> property.count_type >> property.type;
      words >> property.name;
      header.elements.back().properties.push_back(property);
    }
  }
  require(false, path, ": the header has no end_header");
  return header;
}

class ValueReader {
 public:
  ValueReader(std::istream& in, bool binary, const std::string& path) : in_(in), binary_(binary), path_(path) {}

  double next(const std::string& type) {
    double value = 0;
    if (!binary_) {
      in_ >> value;
    } else {
      value = binaryValue(type);
    }
    require(static_cast<bool>(in_), path_, ": the file ends before its last element (truncated?)");
    return value;
  }

 private:
  template <class T>
  double raw() {
    T value{};
    in_.read(reinterpret_cast<char*>(&value), sizeof(T));
    return static_cast<double>(value);
  }

  double binaryValue(const std::string& type) {
    if (type == "float" || type == "float32") return raw<float>();
    if (type == "double" || type == "float64") return raw<double>();
    if (type == "uchar" || type == "uint8") return raw<std::uint8_t>();
    if (type == "char" || type == "int8") return raw<std::int8_t>();
    if (type == "short" || type == "int16") return raw<std::int16_t>();
    if (type == "ushort" || type == "uint16") return raw<std::uint16_t>();
    if (type == "int" || type == "int32") return raw<std::int32_t>();
    if (type == "uint" || type == "uint32") return raw<std::uint32_t>();
    require(false, path_, ": unknown property type '", type, "'");
    return 0;
  }

  std::istream& in_;
  bool binary_;
  std::string path_;
};

void readVertices(const Element& element, ValueReader& reader, Mesh& mesh) {
  mesh.vertices.setZero(3, static_cast<Eigen::Index>(element.count));
  for (std::size_t v = 0; v < element.count; ++v) {
    for (const Property& property : element.properties) {
      const double value = reader.next(property.type);
      if (property.name.size() != 1 || property.name[0] < 'x' || property.name[0] > 'z') continue;
      mesh.vertices(property.name[0] - 'x', static_cast<Eigen::Index>(v)) = static_cast<float>(value);
    }
  }
}

/// Corners of one element's list properties; those of a face are in the list named vertex_index or vertex_indices.
std::vector<int> readCorners(const Element& element, ValueReader& reader) {
  std::vector<int> corners;
  for (const Property& property : element.properties) {
    const bool is_list = !property.count_type.empty();
    const auto count = is_list ? static_cast<std::size_t>(reader.next(property.count_type)) : 1;
    for (std::size_t i = 0; i < count; ++i) {
      const double value = reader.next(property.type);
      if (is_list && property.name.rfind("vertex_ind", 0) == 0) corners.push_back(static_cast<int>(value));
    }
  }
  return corners;
}

}  // namespace

Mesh readMesh(const std::string& path) {
  std::ifstream in(path, std::ios::binary);
  require(static_cast<bool>(in), path, ": cannot open the mesh");
  const Header header = readHeader(in, path);
  ValueReader reader(in, header.binary, path);
  Mesh mesh;
  std::vector<Eigen::Vector3i> faces;
  for (const Element& element : header.elements) {
    if (element.name == "vertex") {
      readVertices(element, reader, mesh);
      continue;
    }
    for (std::size_t e = 0; e < element.count; ++e) {
      const std::vector<int> corners = readCorners(element, reader);
      for (std::size_t c = 2; element.name == "face" && c < corners.size(); ++c) {
        faces.emplace_back(corners[0], corners[c - 1], corners[c]);
      }
    }
  }
  require(!faces.empty(), path, ": the mesh has no faces; the test bed samples points on faces, so give a mesh, not a ",
          "point cloud");
  mesh.faces.resize(3, static_cast<Eigen::Index>(faces.size()));
  for (std::size_t f = 0; f < faces.size(); ++f) {
    require(faces[f].minCoeff() >= 0 && faces[f].maxCoeff() < mesh.vertices.cols(), path, ": face ", f,
            " has a vertex index outside [0, ", mesh.vertices.cols(), ")");
    mesh.faces.col(static_cast<Eigen::Index>(f)) = faces[f];
  }
  const auto slash = path.find_last_of('/');
  const std::string file = slash == std::string::npos ? path : path.substr(slash + 1);
  mesh.name = file.substr(0, file.find_last_of('.'));
  mesh.normals = vertexNormals(mesh.vertices, mesh.faces);
  return mesh;
}

}  // namespace cloud_colorizer
