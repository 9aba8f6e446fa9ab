// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause
#include "recording/recording_files.hpp"

#include <fcntl.h>
#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <functional>
#include <type_traits>

#include "base/file_io.hpp"
#include "base/text.hpp"
#include "cloud_colorizer/base/check.hpp"

namespace cloud_colorizer {

namespace {

std::string infoPath(const std::string& directory) {
  return directory + "/recording.yaml";
}
std::string camerasPath(const std::string& directory) {
  return directory + "/cameras.yaml";
}

/// Runs `parse` on the file; whatever is wrong in it becomes one error that names the file.
void parseYaml(const std::string& path, const std::function<void(const YAML::Node&)>& parse) {
  const auto bytes = readFile(path);
  try {
    parse(YAML::Load(std::string(bytes.begin(), bytes.end())));
  } catch (const YAML::Exception& error) {
    throw std::runtime_error(path + " is damaged: " + error.what());
  } catch (const std::invalid_argument& error) {
    throw std::runtime_error(path + " is damaged: " + error.what());
  }
}

void writeYaml(const std::string& path, const YAML::Emitter& out) {
  AtomicFile file(path);
  file.append(out.c_str(), out.size());
  file.append("\n", 1);
  file.commit(true);
}

std::vector<Field> parseFields(const YAML::Node& nodes) {
  std::vector<Field> fields;
  for (const auto& node : nodes) {
    fields.push_back({node["name"].as<std::string>(), fieldTypeFromString(node["type"].as<std::string>()),
                      node["count"].as<std::uint32_t>()});
  }
  checkFields(fields);
  return fields;
}

RecordingInfo parseInfo(const YAML::Node& node, const std::string& path) {
  const auto version = node["format_version"].as<std::string>();
  require(version == std::to_string(kRecordingVersion), path, " has format version ", version,
          ", but this program reads version ", kRecordingVersion,
          "; use the program that made it, or record into another directory");
  RecordingInfo info;
  info.map_frame = node["map_frame"].as<std::string>();
  info.voxel_size = node["voxel_size"].as<double>();
  info.tile_size = node["tile_size"].as<double>();
  require<std::invalid_argument>(info.voxel_size >= 0 && info.tile_size > 0, "voxel_size ", info.voxel_size,
                                 " or tile_size ", info.tile_size, " is not positive");
  if (const auto origin = node["origin"]) {
    info.origin.emplace(origin[0].as<double>(), origin[1].as<double>(), origin[2].as<double>());
  }
  if (const auto fields = node["fields"]) info.fields = parseFields(fields);
  return info;
}

/// Calls f(name, number) for each number of a camera, as the file has them.
template <class IntrinsicsT, class F>
void visitNumbers(IntrinsicsT& k, F&& f) {
  f("width", k.width), f("height", k.height), f("fx", k.fx), f("fy", k.fy), f("cx", k.cx), f("cy", k.cy);
}

RecordedCamera parseCamera(const YAML::Node& node) {
  RecordedCamera camera;
  Intrinsics& k = camera.intrinsics;
  camera.name = node["name"].as<std::string>();
  visitNumbers(k, [&](const char* name, auto& number) { number = node[name].as<std::decay_t<decltype(number)>>(); });
  k.model = distortionModelFromString(node["distortion_model"].as<std::string>());
  k.distortion = node["distortion"].as<std::vector<double>>();
  camera.mask = node["mask"].as<std::string>();
  constexpr int kMaxSide = 1 << 20;  // px; OpenCV reads no wider image
  const Camera checked(k);
  require<std::invalid_argument>(std::max(k.width, k.height) <= kMaxSide, "an image of ", k.width, " x ", k.height,
                                 " px is larger than any can be: ", kMaxSide, " px a side");
  return camera;
}

void emitCamera(YAML::Emitter& out, const RecordedCamera& camera) {
  out << YAML::BeginMap << YAML::Key << "name" << YAML::Value << camera.name;
  visitNumbers(camera.intrinsics, [&](const char* name, const auto& number) {
    out << YAML::Key << name << YAML::Value << formatDouble(number);
  });
  out << YAML::Key << "distortion_model" << YAML::Value << toString(camera.intrinsics.model);
  out << YAML::Key << "distortion" << YAML::Value << YAML::Flow << YAML::BeginSeq;
  for (const auto coefficient : camera.intrinsics.distortion) out << formatDouble(coefficient);
  out << YAML::EndSeq << YAML::Key << "mask" << YAML::Value << YAML::DoubleQuoted << camera.mask << YAML::EndMap;
}

constexpr const char* kViewsHeader = "camera,stamp,x,y,z,qx,qy,qz,qw,image\n";
constexpr const char* kScansHeader = "stamp,x,y,z,qx,qy,qz,qw,ranges\n";

std::string viewsPath(const std::string& directory) {
  return directory + "/views.csv";
}
std::string scansPath(const std::string& directory) {
  return directory + "/scans.csv";
}

/// `count` numbers and then the name of a file.
std::vector<double> parseNumbers(const std::vector<std::string>& parts, std::size_t count, const std::string& where) {
  require(parts.size() == count + 1, where, " is damaged: it has ", parts.size(), " values instead of ", count + 1);
  std::vector<double> values(count);
  for (std::size_t i = 0; i < count; ++i) {
    require(parseDouble(parts[i], values[i]) && std::isfinite(values[i]), where, " is damaged: \"", parts[i],
            "\" is no number");
  }
  return values;
}

/// x, y, z, qx, qy, qz, qw.
Eigen::Isometry3d parsePose(const double* values, const std::string& where) {
  const Eigen::Quaterniond rotation(values[6], values[3], values[4], values[5]);
  require(std::abs(rotation.norm() - 1) < 1e-3, where, " is damaged: its quaternion has the norm ", rotation.norm());
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
  pose.translation() = Eigen::Vector3d(values[0], values[1], values[2]);
  pose.linear() = rotation.normalized().toRotationMatrix();
  return pose;
}

std::string poseText(const Eigen::Isometry3d& pose) {
  const Eigen::Quaterniond rotation(pose.linear());
  std::string text;
  for (int axis = 0; axis < 3; ++axis) text += ',' + formatDouble(pose.translation()[axis]);
  for (int i = 0; i < 4; ++i) text += ',' + formatDouble(rotation.coeffs()[i]);
  return text;
}

View parseView(const std::string& line, const std::string& where) {
  const auto parts = splitAt(line, ',');
  const std::vector<double> values = parseNumbers(parts, 9, where);
  require(values[0] >= 0 && values[0] < 1e6, where, " is damaged: there is no camera ", parts[0]);
  View view;
  view.camera = static_cast<std::uint32_t>(values[0]);
  view.stamp = values[1];
  view.map_from_camera = parsePose(values.data() + 2, where);
  view.image = parts.back();
  return view;
}

Scan parseScan(const std::string& line, const std::string& where) {
  const auto parts = splitAt(line, ',');
  const std::vector<double> values = parseNumbers(parts, 8, where);
  return {values[0], parsePose(values.data() + 1, where), parts.back()};
}

template <class Row>
Table<Row> readTable(const std::string& path, const std::string& header,
                     Row (*parse)(const std::string&, const std::string&)) {
  Table<Row> table;
  if (!std::filesystem::exists(path)) return table;
  const auto bytes = readFile(path);
  const std::string text(bytes.begin(), bytes.end());
  std::size_t number = 0;
  for (auto end = text.find('\n'); end != std::string::npos; end = text.find('\n', table.num_bytes)) {
    const auto line = text.substr(table.num_bytes, end - table.num_bytes);
    const auto where = path + " line " + std::to_string(++number);
    if (number == 1) {
      require(line + '\n' == header, where, " is damaged: it must be ", header);
    } else {
      table.rows.push_back(parse(line, where));
    }
    table.num_bytes = end + 1;
  }
  return table;
}

}  // namespace

bool hasRecording(const std::string& directory) {
  return std::filesystem::exists(infoPath(directory));
}

RecordingInfo readInfo(const std::string& directory) {
  const auto path = infoPath(directory);
  RecordingInfo info;
  parseYaml(path, [&](const YAML::Node& node) { info = parseInfo(node, path); });
  return info;
}

void writeInfo(const std::string& directory, const RecordingInfo& info) {
  YAML::Emitter out;
  out << YAML::BeginMap << YAML::Key << "format_version" << YAML::Value << kRecordingVersion;
  out << YAML::Key << "map_frame" << YAML::Value << YAML::DoubleQuoted << info.map_frame;
  out << YAML::Key << "voxel_size" << YAML::Value << formatDouble(info.voxel_size);
  out << YAML::Key << "tile_size" << YAML::Value << formatDouble(info.tile_size);
  if (info.origin) {
    out << YAML::Key << "origin" << YAML::Value << YAML::Flow << YAML::BeginSeq;
    for (int axis = 0; axis < 3; ++axis) out << formatDouble((*info.origin)[axis]);
    out << YAML::EndSeq;
  }
  if (info.fields) {
    out << YAML::Key << "fields" << YAML::Value << YAML::BeginSeq;
    for (const auto& field : *info.fields) {
      out << YAML::Flow << YAML::BeginMap << YAML::Key << "name" << YAML::Value << YAML::DoubleQuoted << field.name
          << YAML::Key << "type" << YAML::Value << toString(field.type) << YAML::Key << "count" << YAML::Value
          << field.count << YAML::EndMap;
    }
    out << YAML::EndSeq;
  }
  out << YAML::EndMap;
  writeYaml(infoPath(directory), out);
}

std::vector<RecordedCamera> readCameras(const std::string& directory) {
  std::vector<RecordedCamera> cameras;
  if (!std::filesystem::exists(camerasPath(directory))) return cameras;
  parseYaml(camerasPath(directory), [&](const YAML::Node& node) {
    for (const auto& camera : node["cameras"]) cameras.push_back(parseCamera(camera));
  });
  return cameras;
}

void writeCameras(const std::string& directory, const std::vector<RecordedCamera>& cameras) {
  YAML::Emitter out;
  out << YAML::BeginMap << YAML::Key << "cameras" << YAML::Value << YAML::BeginSeq;
  for (const auto& camera : cameras) emitCamera(out, camera);
  out << YAML::EndSeq << YAML::EndMap;
  writeYaml(camerasPath(directory), out);
}

Table<View> readViews(const std::string& directory) {
  return readTable(viewsPath(directory), kViewsHeader, parseView);
}

Table<Scan> readScans(const std::string& directory) {
  return readTable(scansPath(directory), kScansHeader, parseScan);
}

std::string viewLine(const View& view) {
  return std::to_string(view.camera) + ',' + formatFixed(view.stamp, 9) + poseText(view.map_from_camera) + ',' +
         view.image + '\n';
}

std::string scanLine(const Scan& scan) {
  return formatFixed(scan.stamp, 9) + poseText(scan.map_from_sensor) + ',' + scan.image + '\n';
}

TableWriter TableWriter::ofViews(const std::string& directory) {
  return {viewsPath(directory), kViewsHeader, readViews(directory).num_bytes};
}

TableWriter TableWriter::ofScans(const std::string& directory) {
  return {scansPath(directory), kScansHeader, readScans(directory).num_bytes};
}

TableWriter::TableWriter(const std::string& path, const char* header, std::uint64_t num_bytes)
    : file_(path, O_WRONLY | O_CREAT), size_(num_bytes) {
  file_.truncate(size_);
  if (size_ == 0) append(header);
}

void TableWriter::append(const std::string& line) {
  file_.writeAt(size_, line.data(), line.size());
  size_ += line.size();
}

}  // namespace cloud_colorizer
