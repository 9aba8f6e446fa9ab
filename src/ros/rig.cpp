// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause

/// bag_source.hpp: the rig.

#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <cctype>
#include <filesystem>
#include <set>
#include <sstream>

#include "base/param_text.hpp"
#include "base/text.hpp"
#include "cloud_colorizer/base/check.hpp"
#include "cloud_colorizer/ros/bag_source.hpp"
#include "cloud_colorizer/ros/conversions.hpp"
#include "ros/livox.hpp"

namespace cloud_colorizer {
namespace {

const char* const kCloud = "sensor_msgs/PointCloud2";
const char* const kImage = "sensor_msgs/Image";
const char* const kCompressed = "sensor_msgs/CompressedImage";
const char* const kInfo = "sensor_msgs/CameraInfo";
const char* const kOdometry = "nav_msgs/Odometry";
const char* const kPose = "geometry_msgs/PoseStamped";

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
  checkKeys(node,
            {"image", "camera_info", "time_offset", "mask", "masks", "model", "rectified", "readout_time", "kind",
             "quantity", "scale", "offset", "names"},
            file);
  require(static_cast<bool>(node["image"]), file, ": a camera has no image; an example:\n", exampleRig());
  RigCamera camera;
  camera.image = node["image"].as<std::string>();
  camera.camera_info = node["camera_info"] ? node["camera_info"].as<std::string>() : siblingInfo(camera.image);
  camera.params.rectified = isRectified(camera.image);
  if (node["rectified"]) camera.params.rectified = node["rectified"].as<bool>();
  if (node["readout_time"]) camera.params.readout_time = node["readout_time"].as<double>();
  if (node["model"]) camera.params.model = node["model"].as<std::string>();
  if (node["masks"]) camera.masks = node["masks"].as<std::string>();
  camera.params.masks = !camera.masks.empty();
  if (node["time_offset"]) camera.params.time_offset = node["time_offset"].as<double>();
  const auto besideRig = [&](const char* key) -> std::string {
    if (!node[key] || node[key].as<std::string>().empty()) return {};
    return (std::filesystem::path(file).parent_path() / node[key].as<std::string>()).string();
  };
  camera.params.mask = besideRig("mask");
  if (node["kind"]) camera.params.kind = parseValue<ImageKind>(file + ": kind", node["kind"].as<std::string>());
  if (camera.params.kind == ImageKind::kColor) {
    for (const char* key : {"quantity", "scale", "offset", "names"}) {
      require(!node[key], file, ": unknown key ", key,
              " of a camera of colours; it is for kind: radiometric, labels or ",
              "logits. Stamps are shifted by time_offset; an example:\n", exampleRig());
    }
  }
  if (node["quantity"]) camera.params.quantity = node["quantity"].as<std::string>();
  if (node["scale"]) camera.params.scale = node["scale"].as<double>();
  if (node["offset"]) camera.params.offset = node["offset"].as<double>();
  camera.params.names = besideRig("names");
  return camera;
}

[[noreturn]] void failToGuess(const std::string& why, const TopicTypes& topics) {
  throw std::runtime_error(why + " Give --config with a rig file. " + listTopics(topics) +
                           "An example of a rig file:\n" + exampleRig());
}

// ---- which images have colours ----

struct ImageTopic {
  std::string topic, info;
  std::string format;    ///< encoding of raw images, format of compressed ones; empty: unknown
  std::string left_out;  ///< why; empty: it is taken
};

/// The words of a topic; where the image has colours, whole parts of it only: a camera may be called depth_camera.
bool hasWord(const std::string& topic, bool has_colors, const std::vector<std::string>& words) {
  std::string lower = lowerCase(topic), word;
  std::replace_if(
      lower.begin(), lower.end(), [&](unsigned char c) { return has_colors ? c == '/' : std::isalpha(c) == 0; }, ' ');
  for (std::istringstream rest(lower); rest >> word;) {
    if (std::find(words.begin(), words.end(), word) != words.end()) return true;
  }
  return false;
}

std::string encodingOf(const ImageTopic& image) {
  const std::string of_format = encodingOfFormat(image.format);
  return of_format.empty() ? image.format : of_format;
}

std::string whyNoColors(const ImageTopic& image) {
  const std::string encoding = encodingOf(image);
  if (endsWith(image.topic, "/compressedDepth") || image.format.find("compressedDepth") != std::string::npos) {
    return "holds depths";
  }
  if (isOfValues(encoding)) return "holds depths or other values (" + encoding + ")";
  const bool has_colors = !encoding.empty() && !isGrey(encoding);
  const auto named = [&](const std::vector<std::string>& words) { return hasWord(image.topic, has_colors, words); };
  if (named({"depth", "disparity"})) return "holds depths by its name";
  if (named({"infra", "infrared", "ir", "nir", "nearir"})) return "is infrared by its name";
  if (!has_colors && named({"thermal", "lwir", "flir"})) return "is thermal by its name";
  if (hasWord(image.topic, false,
              {"mask", "label", "labels", "segmentation", "confidence", "detections", "debug", "overlay", "annotated",
               "visualization"})) {
    return "holds no colours by its name";
  }
  return {};
}

/// Grey cameras beside coloured ones would make the map grey where they look. All grey: they are what there is.
void leaveOutGrey(std::vector<ImageTopic>& images) {
  const bool any_color = std::any_of(images.begin(), images.end(), [](const ImageTopic& image) {
    return image.left_out.empty() && !isGrey(encodingOf(image));
  });
  for (ImageTopic& image : images) {
    if (any_color && image.left_out.empty() && isGrey(encodingOf(image))) {
      image.left_out = "is grey (" + encodingOf(image) + "), and there are cameras with colours";
    }
  }
}

/// Of the topics of one camera, raw, compressed or made by image_proc, the first is taken.
void leaveOutCompanions(std::vector<ImageTopic>& images) {
  std::map<std::string, std::string> image_of_info;
  for (ImageTopic& image : images) {
    if (!image.left_out.empty()) continue;
    const auto [first, is_new] = image_of_info.emplace(image.info, image.topic);
    if (!is_new) image.left_out = "shows the same as " + first->second;
  }
}

}  // namespace

std::string exampleRig() {
  return "cloud_in: /points\n"
         "cameras:\n"
         "  - image: /front/image_raw/compressed\n"
         "    camera_info: /front/camera_info   # may be left out: the one beside the image\n"
         "    time_offset: 0.0                  # s, added to the image stamps\n"
         "    mask: front_mask.png              # black where the camera must not colour; may be left out\n"
         "    # masks: /front/segmentation      # images that are black there, one for each image, by its stamp\n"
         "    rectified: false                  # true: P counts, without distortion\n"
         "    # readout_time: 0.02             # s from the first row to the last, of a rolling shutter\n"
         "    # model: equirectangular          # images of all directions, which need no camera_info\n"
         "  # - image: /thermal/image           # a camera that shows no colours\n"
         "  #   kind: radiometric               # or labels, logits\n"
         "  #   quantity: temperature           # field of the map\n"
         "  #   scale: 0.01                     # value = scale * number + offset\n"
         "  #   offset: -273.15\n"
         "  #   names: classes.txt              # labels, logits: what they mean; kept beside the map\n"
         "map_frame: map                        # may be left out\n"
         "# odometry: /odom                     # nav_msgs/Odometry or geometry_msgs/PoseStamped, where tf has no "
         "poses\n"
         "# base_frame: base_link               # whose poses those are, where the messages do not say it\n";
}

Rig readRig(const std::string& file, const TopicTypes& topics) {
  require(std::filesystem::is_regular_file(file), "the rig file ", file, " does not exist");
  Rig rig;
  try {
    const YAML::Node node = YAML::LoadFile(file);
    require(node.IsMap(), file, ": this is no rig file; an example:\n", exampleRig());
    checkKeys(node, {"map_frame", "cloud_in", "cameras", "odometry", "base_frame"}, file);
    require(node["cloud_in"] && node["cameras"] && node["cameras"].IsSequence(), file,
            ": cloud_in or the list of cameras is missing; an example:\n", exampleRig());
    if (node["map_frame"]) rig.map_frame = node["map_frame"].as<std::string>();
    if (node["odometry"]) rig.odometry = node["odometry"].as<std::string>();
    if (node["base_frame"]) rig.base_frame = node["base_frame"].as<std::string>();
    rig.cloud = node["cloud_in"].as<std::string>();
    for (const YAML::Node& camera : node["cameras"]) rig.cameras.push_back(readCamera(camera, file));
  } catch (const YAML::Exception& error) {
    throw std::runtime_error(file + ": " + error.what());
  } catch (const std::invalid_argument& error) {
    throw std::runtime_error(error.what());
  }
  const auto cloud = topics.find(rig.cloud);
  if (cloud == topics.end() || !isLivoxType(cloud->second)) checkTopic(topics, rig.cloud, {kCloud}, file);
  if (!rig.odometry.empty()) checkTopic(topics, rig.odometry, {kOdometry, kPose}, file);
  for (const RigCamera& camera : rig.cameras) {
    checkTopic(topics, camera.image, {kImage, kCompressed}, file);
    if (!camera.params.isPanorama()) checkTopic(topics, camera.camera_info, {kInfo}, file);
    if (!camera.masks.empty()) checkTopic(topics, camera.masks, {kImage, kCompressed}, file);
  }
  return rig;
}

Rig guessRig(const TopicTypes& topics, const FormatOf& format_of) {
  Rig rig;
  std::vector<ImageTopic> images;
  for (const auto& [topic, type] : topics) {  // in alphabetical order: a raw topic comes before its compressed one
    if (type == kCloud || isLivoxType(type)) {
      if (!rig.cloud.empty()) failToGuess("The bag has more than one cloud topic.", topics);
      rig.cloud = topic;
    }
    if (type != kImage && type != kCompressed) continue;
    const std::string info = siblingInfo(topic);
    if (!hasType(topics, info, {kInfo})) continue;
    images.push_back({topic, info, format_of ? format_of(topic) : "", ""});
    images.back().left_out = whyNoColors(images.back());
  }
  leaveOutGrey(images);
  leaveOutCompanions(images);
  for (const ImageTopic& image : images) {
    if (!image.left_out.empty()) {
      rig.left_out.emplace_back(image.topic, image.left_out);
      continue;
    }
    rig.cameras.push_back({image.topic, image.info, {}, {}});
    rig.cameras.back().params.rectified = isRectified(image.topic);
  }
  if (rig.cloud.empty()) failToGuess("The bag has no cloud topic.", topics);
  if (rig.cameras.empty()) {
    std::string why = "The bag has no image topic with a camera_info beside it.";
    if (!images.empty()) why = "The bag has no images of colours:";
    for (const ImageTopic& image : images) why += " " + image.topic + " " + image.left_out + ".";
    failToGuess(why, topics);
  }
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
  if (!rig.poses.empty()) out << "\nposes: " << rig.poses.size() << " of " << rig.base_frame;
  if (!rig.odometry.empty()) out << "\nodometry: " << rig.odometry << ", map_frame: " << rig.map_frame;
  for (const auto& [topic, why] : rig.left_out) out << "\nleft out: " << topic << ' ' << why;
  return out.str();
}

}  // namespace cloud_colorizer
