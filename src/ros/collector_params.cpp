// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause
#include <sstream>
#include <stdexcept>

#include "cloud_colorizer/base/check.hpp"
#include "cloud_colorizer/ros/collector.hpp"

namespace cloud_colorizer {

const char* toString(Outcome outcome) {
  static const char* const kNames[] = {"kept",
                                       "not a keyframe",
                                       "already recorded",
                                       "no transform",
                                       "no camera_info",
                                       "bad camera_info",
                                       "too large",
                                       "size differs from camera_info",
                                       "undecodable",
                                       "malformed",
                                       "no stamp",
                                       "stamp out of range",
                                       "dropped when time jumped back",
                                       "dropped from a full queue"};
  return kNames[static_cast<std::size_t>(outcome)];
}

void CollectorParams::check() const {
  require<std::invalid_argument>(!map_frame.empty() && map_frame != "/", "parameter map_frame must not be empty");
  requireInRange("tf_wait", tf_wait, 0.0, 3600.0);
  require<std::invalid_argument>(raw_image_format == "png" || raw_image_format == "ppm" || raw_image_format == "jpg",
                                 "parameter raw_image_format = \"", raw_image_format,
                                 "\" must be one of: ppm, png, jpg");
  requireInRange("encode_threads", encode_threads, 1, 64);
  requireInRange("max_image_size", max_image_size, 1e-6, 1000.0);  // OpenCV reads up to 2^30 px
  for (std::size_t i = 0; i < cameras.size(); ++i) {
    const std::string name = "camera_" + std::to_string(i) + "/time_offset";
    requireInRange(name.c_str(), cameras[i].time_offset, -60.0, 60.0);
  }
  record.check();
}

std::string CollectorStats::describe() const {
  std::ostringstream out;
  const auto line = [&out](const std::string& name, const StreamStats& stats) {
    out << name << ": " << stats.received << " received";
    for (std::size_t i = 0; i < stats.outcomes.size(); ++i) {
      if (stats.outcomes[i] > 0) out << ", " << stats.outcomes[i] << ' ' << toString(static_cast<Outcome>(i));
    }
    out << '\n';
  };
  line("clouds", cloud);
  for (std::size_t i = 0; i < cameras.size(); ++i) line("camera_" + std::to_string(i), cameras[i]);
  if (bad_transforms > 0) out << "tf: " << bad_transforms << " stamp out of range\n";
  out << "points: " << points.added << " recorded, " << points.voxel_taken << " in a voxel that is taken, "
      << points.too_near << " too near, " << points.too_far << " too far, " << points.not_finite << " not finite";
  return out.str();
}

}  // namespace cloud_colorizer
