// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause

/// Bags as a source of messages, and the rig: which topic is the cloud and which are the cameras.
#pragma once

#include <geometry_msgs/TransformStamped.h>

#include <functional>
#include <map>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "cloud_colorizer/base/types.hpp"
#include "cloud_colorizer/ros/collector.hpp"

namespace cloud_colorizer {

struct RigCamera {
  std::string image;        ///< sensor_msgs/Image or CompressedImage
  std::string camera_info;  ///< sensor_msgs/CameraInfo
  CameraParams params;
  std::string masks;  ///< sensor_msgs/Image or CompressedImage, one for each image; empty: none
};

struct Rig {
  std::string map_frame;   ///< empty: as the parameter says
  std::string cloud;       ///< sensor_msgs/PointCloud2 or livox_ros_driver(2)/CustomMsg
  std::string odometry;    ///< nav_msgs/Odometry or geometry_msgs/PoseStamped that stands in for tf; empty: none
  std::string base_frame;  ///< whose pose it gives; empty: as its messages say
  /// By stamp, of base_frame, instead of what tf and odometry say of it.
  std::vector<geometry_msgs::TransformStamped> poses;
  std::vector<RigCamera> cameras;
  std::vector<std::pair<std::string, std::string>> left_out;  ///< image topics that are not taken, and why
};

/// Topic -> type, e.g. "/points" -> "sensor_msgs/PointCloud2".
using TopicTypes = std::map<std::string, std::string>;

/// Reads a rig file (see exampleRig). Masks are relative to the file. A camera_info that is not given is the one beside
/// the image. Throws std::runtime_error: unreadable, unknown key, a topic that is not in the bag or has another type.
Rig readRig(const std::string& file, const TopicTypes& topics);

/// Encoding of the first image of a topic, or the format of the first compressed one; empty: unknown.
using FormatOf = std::function<std::string(const std::string& topic)>;

/// The rig of a bag with one cloud topic and any number of image topics with a camera_info in the same namespace.
/// Depth, infrared and thermal images, masks, and grey cameras beside coloured ones are left out, by their format and
/// name; of several topics with one camera_info, the first is taken. Throws std::runtime_error, with the topics and an
/// example of a rig file, when there is more than one way to read the bag, or none.
Rig guessRig(const TopicTypes& topics, const FormatOf& format_of = {});

std::string exampleRig();
std::string describeRig(const Rig& rig);  ///< one line a topic

/// Reads bags as if they were one. Every function throws std::runtime_error, with the remedy, on a damaged bag.
class BagSource {
 public:
  explicit BagSource(const std::vector<std::string>& bags);
  ~BagSource();

  const TopicTypes& topics() const;
  double duration() const;  ///< s
  /// As FormatOf.
  std::string formatOf(const std::string& topic) const;
  /// Takes the bag's only odometry topic where tf does not move the frame that it tells of.
  void addOdometry(Rig& rig) const;
  /// Takes the poses of a file (readTrajectory) for those of rig.base_frame, or where that is empty of the first
  /// cloud's frame. Poses without stamps are of the clouds, one for each. Throws std::runtime_error.
  void addPoses(const std::string& file, const std::string& map_frame, Rig& rig) const;

  /// Gives all messages to the collector in the order of the bag: all static transforms and the first camera_info of
  /// each camera first, the other transforms `tf_lead` seconds ahead (not across a step back in time). Calls
  /// collector.finish() at the end. Throws Cancelled.
  void play(const Rig& rig, double tf_lead, Collector& collector, const Callbacks& callbacks);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace cloud_colorizer
