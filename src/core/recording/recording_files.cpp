// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause
#include "recording/recording_files.hpp"

#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <filesystem>
#include <functional>
#include <type_traits>

#include "base/file_io.hpp"
#include "base/param_text.hpp"
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
  if (const auto max_range = node["max_range"]) info.max_range = max_range.as<double>();
  require<std::invalid_argument>(info.max_range > 0, "max_range ", info.max_range, " is not positive");
  if (const auto origin = node["origin"]) {
    info.origin.emplace(origin[0].as<double>(), origin[1].as<double>(), origin[2].as<double>());
  }
  if (const auto crs = node["crs"]) info.crs = crs.as<std::string>();
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
  if (const auto kind = node["kind"]) {
    Quantity& quantity = camera.quantity;
    quantity.kind = parseValue<ImageKind>("kind", kind.as<std::string>());
    quantity.name = node["quantity"].as<std::string>();
    quantity.scale = node["scale"].as<double>();
    quantity.offset = node["offset"].as<double>();
    quantity.names = node["names"].as<std::string>();
    quantity.check();
  }
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
  out << YAML::EndSeq << YAML::Key << "mask" << YAML::Value << YAML::DoubleQuoted << camera.mask;
  const Quantity& quantity = camera.quantity;
  if (quantity.kind != ImageKind::kColor) {
    out << YAML::Key << "kind" << YAML::Value << formatValue(quantity.kind);
    out << YAML::Key << "quantity" << YAML::Value << quantity.name;
    out << YAML::Key << "scale" << YAML::Value << formatDouble(quantity.scale);
    out << YAML::Key << "offset" << YAML::Value << formatDouble(quantity.offset);
    out << YAML::Key << "names" << YAML::Value << YAML::DoubleQuoted << quantity.names;
  }
  out << YAML::EndMap;
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

double defaultTileSize(const RecordParams& params) {
  if (params.tile_size > 0) return params.tile_size;
  return params.voxel_size > 0 ? 200 * params.voxel_size : 2.5;
}

RecordingInfo newInfo(const std::string& directory, const std::string& map_frame, const RecordParams& params) {
  RecordingInfo info;
  info.map_frame = map_frame;
  info.voxel_size = params.voxel_size;
  info.tile_size = defaultTileSize(params);
  info.max_range = params.max_range;
  writeInfo(directory, info);
  return info;
}

void writeInfo(const std::string& directory, const RecordingInfo& info) {
  YAML::Emitter out;
  out << YAML::BeginMap << YAML::Key << "format_version" << YAML::Value << kRecordingVersion;
  out << YAML::Key << "map_frame" << YAML::Value << YAML::DoubleQuoted << info.map_frame;
  out << YAML::Key << "voxel_size" << YAML::Value << formatDouble(info.voxel_size);
  out << YAML::Key << "tile_size" << YAML::Value << formatDouble(info.tile_size);
  if (std::isfinite(info.max_range)) out << YAML::Key << "max_range" << YAML::Value << formatDouble(info.max_range);
  if (!info.crs.empty()) out << YAML::Key << "crs" << YAML::Value << YAML::DoubleQuoted << info.crs;
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

bool isFileName(const std::string& name) {
  const auto allowed = [](unsigned char c) { return std::isalnum(c) != 0 || c == '_' || c == '-' || c == '.'; };
  return !name.empty() && name.front() != '.' && std::all_of(name.begin(), name.end(), allowed);
}

void makeFolder(const std::string& directory, const std::string& name) {
  std::filesystem::create_directory(directory + '/' + name);
}

}  // namespace cloud_colorizer
