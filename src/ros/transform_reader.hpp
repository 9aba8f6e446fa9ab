// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause

/// The poses of a bag, read ahead of its clouds and images: what mapping programs publish comes late.
#pragma once

#include <rosbag/view.h>

#include <map>
#include <memory>
#include <set>
#include <string>
#include <vector>

#include "cloud_colorizer/ros/bag_source.hpp"
#include "ros/clock_watch.hpp"

namespace cloud_colorizer {

/// Topics of transforms that move, as bags name them; the clocks of others are compared with the first.
const std::vector<std::string> kTfTopics = {"/tf", "tf"};

/// Gives transforms to the collector, ahead of the other messages.
class TransformReader {
 public:
  /// `view`: of tf and the rig's odometry; `lead` [s] ahead of what is asked for.
  TransformReader(std::unique_ptr<rosbag::View> view, const Rig& rig, double lead, Collector& collector,
                  ClockWatch& clocks);

  /// The fixed tree, with what /tf gives only `once`. Where poses are given, it is turned so that it hangs from their
  /// frame.
  void giveFixed(std::vector<geometry_msgs::TransformStamped> fixed,
                 const std::vector<geometry_msgs::TransformStamped>& once);
  /// The given poses up to `lead` after the stamp of a cloud; again from the first after a step back.
  void givePosesTo(ros::Time stamp);
  /// All that were received up to `lead` after `time`, but not past a step back of their stamps.
  void readTo(ros::Time time);

 private:
  tf2_msgs::TFMessage read() const;
  bool stepsBack(const tf2_msgs::TFMessage& message) const;

  std::unique_ptr<rosbag::View> view_;
  rosbag::View::iterator next_;
  const Rig& rig_;
  std::vector<geometry_msgs::TransformStamped>::const_iterator pose_;
  ros::Time last_stamp_;
  std::set<std::string> known_;  ///< frames whose place is given before, and not told by what comes on /tf
  ros::Duration lead_;
  Collector& collector_;
  ClockWatch& clocks_;
  std::map<std::string, ros::Time> last_;
};

}  // namespace cloud_colorizer
