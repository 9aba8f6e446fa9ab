// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <ros/time.h>

#include <cmath>
#include <map>
#include <sstream>
#include <string>
#include <vector>

#include "base/robust.hpp"
#include "cloud_colorizer/base/types.hpp"

namespace cloud_colorizer {

/// A word about offsets [s] that are within `tolerance` of the one of PTP clocks that nobody corrected; else empty.
inline const char* hintOfTai(double offset, double tolerance) {
  return std::abs(std::abs(offset) - 37) < tolerance ? " (37 s lie between TAI, the time of PTP, and UTC)" : "";
}

/// Tells of topics whose stamps are seconds away from those of tf by the times of receipt, as with PTP without UTC.
class ClockWatch {
 public:
  void add(const std::string& topic, ros::Time receipt, ros::Time stamp) {
    std::vector<double>& delays = delays_[topic];
    if (!stamp.isZero() && delays.size() < kMost) delays.push_back(receipt.toSec() - stamp.toSec());
  }

  /// `tf_topic`: the topic that the others are compared with.
  void warn(const std::string& tf_topic, const Callbacks& callbacks) const {
    const auto tf = delays_.find(tf_topic);
    if (tf == delays_.end() || tf->second.empty() || !callbacks.log) return;
    for (const auto& [topic, delays] : delays_) {
      if (delays.empty()) continue;
      const double offset = median(delays) - median(tf->second);
      if (std::abs(offset) < kNoticed) continue;
      std::ostringstream text;
      text.precision(4);
      text << topic << ": its stamps are " << std::abs(offset) << " s " << (offset > 0 ? "behind" : "ahead of")
           << " those of tf that were received at the same time";
      text << hintOfTai(offset, 1)
           << "; if its clock differs, set its time offset (cloud_time_offset, camera_<i>/time_offset) to " << offset;
      callbacks.log(LogLevel::kWarning, text.str());
    }
  }

 private:
  static constexpr std::size_t kMost = 200;  // messages of a topic
  static constexpr double kNoticed = 10.0;   // s; mapping programs send their poses some seconds late

  std::map<std::string, std::vector<double>> delays_;  ///< s, from stamp to receipt
};

}  // namespace cloud_colorizer
