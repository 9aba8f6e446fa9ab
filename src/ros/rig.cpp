// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause

/// bag_source.hpp: the rig.

#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <filesystem>
#include <set>
#include <sstream>

#include "base/text.hpp"
#include "cloud_colorizer/base/check.hpp"
#include "cloud_colorizer/ros/bag_source.hpp"

namespace cloud_colorizer {
namespace {

const char* const kCloud = "sensor_msgs/PointCloud2";
const char* const kImage = "sensor_msgs/Image";
const char* const kCompressed = "sensor_msgs/CompressedImage";
const char* const kInfo = "sensor_msgs/CameraInfo";

std::string listTopics(const TopicTypes& topics) {
  std::string text = "topics:\n";
  for (const auto& [topic, type] : topics) text += "  " + topic + " (" + type + ")\n";
  return text;
}

/// "/cam/image/compressed" -> "/cam/image".
std::string withoutTransport(const std::string& topic) {
  const std::string suffix = "/compressed";
  return endsWith(topic, suffix) ? topic.substr(0, topic.size() - suffix.size()) : topic;
}

std::string siblingInfo(const std::string& image) {
  const std::string base = withoutTransport(image);
  return base.substr(0, base.rfind('/') + 1) + "camera_info";
}

bool isRectified(const std::string& image) {
  const std::string base = withoutTransport(image);
  return base.compare(base.rfind('/') + 1, 10, "image_rect") == 0;
}

bool hasType(const TopicTypes& topics, const std::string& topic, const std::vector<std::string>& types) {
  const auto found = topics.find(topic);
  return found != topics.end() && std::find(types.begin(), types.end(), found->second) != types.end();
}

void checkTopic(const TopicTypes& topics, const std::string& topic, const std::vector<std::string>& types,
                const std::string& file) {
  const auto found = topics.find(topic);
  require(found != topics.end(), file, ": the bag has no topic ", topic, "; ", listTopics(topics));
  require(hasType(topics, topic, types), file, ": ", topic, " is a ", found->second, ", not a ", types.front());
}

void checkKeys(const YAML::Node& node, const std::set<std::string>& known, const std::string& file) {
  for (const auto& entry : node) {
    const std::string key = entry.first.as<std::string>();
    require(known.count(key) != 0, file, ": unknown key ", key, "; an example:\n", exampleRig());
  }
}

RigCamera readCamera(const YAML::Node& node, const std::string& file) {
  checkKeys(node, {"image", "camera_info", "time_offset", "mask", "rectified"}, file);
  require(static_cast<bool>(node["image"]), file, ": a camera has no image; an example:\n", exampleRig());
  RigCamera camera;
  camera.image = node["image"].as<std::string>();
  camera.camera_info = node["camera_info"] ? node["camera_info"].as<std::string>() : siblingInfo(camera.image);
  camera.params.rectified = isRectified(camera.image);
  if (node["rectified"]) camera.params.rectified = node["rectified"].as<bool>();
  if (node["time_offset"]) camera.params.time_offset = node["time_offset"].as<double>();
  if (node["mask"] && !node["mask"].as<std::string>().empty()) {
    camera.params.mask = (std::filesystem::path(file).parent_path() / node["mask"].as<std::string>()).string();
  }
  return camera;
}

[[noreturn]] void failToGuess(const std::string& why, const TopicTypes& topics) {
  throw std::runtime_error(why + " Give --config with a rig file. " + listTopics(topics) +
                           "An example of a rig file:\n" + exampleRig());
}

}  // namespace

std::string exampleRig() {
  return "cloud_in: /points\n"
         "cameras:\n"
         "  - image: /front/image_raw/compressed\n"
         "    camera_info: /front/camera_info   # may be left out: the one beside the image\n"
         "    time_offset: 0.0                  # s, added to the image stamps\n"
         "    mask: front_mask.png              # black where the camera must not colour; may be left out\n"
         "    rectified: false                  # true: P counts, without distortion\n"
         "map_frame: map                        # may be left out\n";
}

Rig readRig(const std::string& file, const TopicTypes& topics) {
  require(std::filesystem::is_regular_file(file), "the rig file ", file, " does not exist");
  Rig rig;
  try {
    const YAML::Node node = YAML::LoadFile(file);
    require(node.IsMap(), file, ": this is no rig file; an example:\n", exampleRig());
    checkKeys(node, {"map_frame", "cloud_in", "cameras"}, file);
    require(node["cloud_in"] && node["cameras"] && node["cameras"].IsSequence(), file,
            ": cloud_in or the list of cameras is missing; an example:\n", exampleRig());
    if (node["map_frame"]) rig.map_frame = node["map_frame"].as<std::string>();
    rig.cloud = node["cloud_in"].as<std::string>();
    for (const YAML::Node& camera : node["cameras"]) rig.cameras.push_back(readCamera(camera, file));
  } catch (const YAML::Exception& error) {
    throw std::runtime_error(file + ": " + error.what());
  }
  checkTopic(topics, rig.cloud, {kCloud}, file);
  for (const RigCamera& camera : rig.cameras) {
    checkTopic(topics, camera.image, {kImage, kCompressed}, file);
    checkTopic(topics, camera.camera_info, {kInfo}, file);
  }
  return rig;
}

Rig guessRig(const TopicTypes& topics) {
  Rig rig;
  std::map<std::string, std::string> image_of_info;
  for (const auto& [topic, type] : topics) {  // in alphabetical order: a raw topic comes before its compressed one
    if (type == kCloud) {
      if (!rig.cloud.empty()) failToGuess("The bag has more than one cloud topic.", topics);
      rig.cloud = topic;
    }
    if ((type != kImage && type != kCompressed) || endsWith(topic, "/compressedDepth")) continue;
    const std::string info = siblingInfo(topic);
    if (!hasType(topics, info, {kInfo})) continue;
    const auto [same, is_new] = image_of_info.emplace(info, topic);
    if (is_new) {
      rig.cameras.push_back({topic, info, {}});
      rig.cameras.back().params.rectified = isRectified(topic);
    } else if (withoutTransport(topic) != withoutTransport(same->second)) {
      failToGuess("Both " + same->second + " and " + topic + " belong to " + info + ".", topics);
    }
  }
  if (rig.cloud.empty()) failToGuess("The bag has no cloud topic.", topics);
  if (rig.cameras.empty()) failToGuess("The bag has no image topic with a camera_info beside it.", topics);
  return rig;
}

std::string describeRig(const Rig& rig) {
  std::ostringstream out;
  out << "cloud_in: " << rig.cloud;
  for (std::size_t i = 0; i < rig.cameras.size(); ++i) {
    const RigCamera& camera = rig.cameras[i];
    out << "\ncamera_" << i << ": " << camera.image << " with " << camera.camera_info
        << (camera.params.rectified ? ", rectified" : "");
  }
  return out.str();
}

}  // namespace cloud_colorizer
