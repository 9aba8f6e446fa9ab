// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause

/// tf as recordings need it: exact stamps, no bridged gaps, and a word about what contradicts itself.
#pragma once

#include <geometry_msgs/TransformStamped.h>
#include <ros/time.h>
#include <tf2/buffer_core.h>

#include <Eigen/Geometry>
#include <deque>
#include <map>
#include <set>
#include <string>

#include "cloud_colorizer/ros/collector.hpp"

namespace cloud_colorizer {

/// A message that cannot be recorded, and why.
struct Refused {
  Outcome outcome;
  std::string reason;
};

/// The transform may still come: the message has to wait.
struct NotYet : Refused {};

/// "/base_link" -> "base_link": tf2 knows no leading slash.
std::string withoutSlash(const std::string& frame);

class TransformBuffer {
 public:
  /// What a frame may do between two transforms and be interpolated all the same, however far they are apart: a
  /// correction that comes once a second, or a vehicle that stands.
  struct Stillness {
    double distance = 0;  ///< m
    double angle = 0;     ///< deg
  };

  /// `cache` [s] of transforms are kept. Between two transforms of a frame that lie more than `max_gap` [s] apart
  /// nothing is interpolated; 0: any gap is bridged.
  TransformBuffer(double cache, double max_gap, const Stillness& stillness);

  /// Takes a transform; one that is there already is passed over. Returns a warning where it contradicts an earlier one
  /// (a static transform with other numbers, a frame with two parents), else an empty text.
  std::string add(const geometry_msgs::TransformStamped& transform, bool is_static);

  /// target_from_source at exactly `stamp`. Throws NotYet with tf's reason, Refused within a gap or for a translation
  /// that is damaged.
  Eigen::Isometry3d lookUp(const std::string& target, const std::string& source, ros::Time stamp) const;

  bool has(const std::string& frame) const { return names_.count(frame) != 0; }

  /// The only frame whose name says that it is a LiDAR's; empty where there is none or more than one.
  std::string scannerFrame() const;

  void clear();  ///< forgets the transforms, as time jumped back; static ones stay

 private:
  struct Edge {
    std::string parent;
    bool is_static = false;
    Eigen::Isometry3d transform = Eigen::Isometry3d::Identity();  ///< the last one
    std::deque<ros::Time> stamps;                                 ///< ascending; of a frame that moves
    bool warned = false;
  };
  void checkGaps(const std::string& target, const std::string& source, ros::Time stamp) const;
  std::string whyUnknown(const std::string& target, const std::string& source) const;
  std::string frames() const;  ///< "base_link, lidar, map"
  bool standsStill(const std::string& child, ros::Time before, ros::Time after) const;
  std::set<std::string> wayToRoot(const std::string& frame) const;

  tf2::BufferCore buffer_;
  double cache_, max_gap_;  ///< s
  Stillness stillness_;
  std::map<std::string, Edge> edges_;  ///< by child
  std::set<std::string> names_;
};

}  // namespace cloud_colorizer
