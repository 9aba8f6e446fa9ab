// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause

/// Stamps that a recording can hold.
#pragma once

#include <std_msgs/Header.h>

#include <cstdint>
#include <limits>
#include <string>

#include "ros/transform_buffer.hpp"

namespace cloud_colorizer {

/// tf and time offsets add up to a day to a stamp, which ros::Time then may not hold.
constexpr std::uint32_t kLastSecond = std::numeric_limits<std::uint32_t>::max() - 2 * 86400;

inline std::string badStamp(ros::Time stamp) {
  return "the stamp of " + std::to_string(stamp.sec) + " s is out of range; look at the publisher's clock";
}

/// Throws Refused.
inline void checkStamp(const std_msgs::Header& header) {
  if (header.stamp.isZero()) throw Refused{Outcome::kNoStamp, "the header's stamp is zero"};
  if (header.stamp.sec > kLastSecond) throw Refused{Outcome::kBadStamp, badStamp(header.stamp)};
}

/// `offset` [s] later. In integers: a double of today's seconds is 0.2 us coarse, and the last transform is at the
/// message's exact stamp. Throws Refused.
inline ros::Time shiftedStamp(ros::Time stamp, double offset) {
  if (stamp.toSec() + offset <= 0) {
    throw Refused{Outcome::kNoStamp, "the stamp with the time offset is before time 0"};
  }
  if (stamp.toSec() + offset > kLastSecond) {
    throw Refused{Outcome::kBadStamp, "the stamp with the time offset is out of range"};
  }
  return stamp + ros::Duration(offset);
}

}  // namespace cloud_colorizer
