// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <sstream>
#include <stdexcept>

#include "cloud_colorizer/base/check.hpp"
#include "cloud_colorizer/ros/collector.hpp"
#include "ros/clock_watch.hpp"

namespace cloud_colorizer {
namespace {

constexpr double kMaxOffset = 2e9;  // s; a clock that counts from the start of the machine is so far off

/// "-37.000" of clocks whose stamps do not meet: what has to be added to those of `stream`.
std::string describeClock(const StreamStats& stream, const StampRange& tf, const char* param) {
  const bool meet =
      stream.stamps.empty() || tf.empty() || (stream.stamps.first <= tf.last && tf.first <= stream.stamps.last);
  if (meet) return {};
  const double offset = tf.first - stream.stamps.first;
  std::ostringstream out;
  out.setf(std::ios::fixed);
  out.precision(3);
  out << "; its stamps run from " << stream.stamps.first << " to " << stream.stamps.last << " s, those of tf from "
      << tf.first << " to " << tf.last << " s: another clock. " << param << "=" << offset
      << " fits if both begin together" << hintOfTai(offset, 2);
  return out.str();
}

/// What became of most messages.
Outcome mostCommon(const StreamStats& stats) {
  const auto most = std::max_element(stats.outcomes.begin() + 1, stats.outcomes.end());
  return static_cast<Outcome>(most - stats.outcomes.begin());
}

std::string whyNothingKept(const StreamStats& stats, const StampRange& tf, const char* param) {
  const Outcome outcome = mostCommon(stats);
  std::ostringstream out;
  out << stats.count(outcome) << " of " << stats.received << ": " << toString(outcome);
  if (!stats.last_error.empty()) out << " (" << stats.last_error << ')';
  if (outcome == Outcome::kNoTransform) out << describeClock(stats, tf, param);
  return out.str();
}

}  // namespace

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
                                       "without a mask",
                                       "malformed",
                                       "no stamp",
                                       "stamp out of range",
                                       "dropped when time jumped back",
                                       "dropped from a full queue"};
  return kNames[static_cast<std::size_t>(outcome)];
}

Quantity CameraParams::toldQuantity() const {
  Quantity told{kind, quantity, scale, offset, names};
  if (kind == ImageKind::kColor) return {};
  if (told.name.empty()) told.name = kind == ImageKind::kRadiometric ? "temperature" : "label";
  return told;
}

void CollectorParams::check() const {
  require<std::invalid_argument>(!map_frame.empty() && map_frame != "/", "parameter map_frame must not be empty");
  requireInRange("tf_wait", tf_wait, 0.0, 3600.0);
  require<std::invalid_argument>(raw_image_format == "png" || raw_image_format == "ppm" || raw_image_format == "jpg",
                                 "parameter raw_image_format = \"", raw_image_format,
                                 "\" must be one of: ppm, png, jpg");
  require<std::invalid_argument>(deskew == "auto" || deskew == "on" || deskew == "off", "parameter deskew = \"", deskew,
                                 "\" must be one of: auto, on, off");
  requireInRange("tf_max_gap", tf_max_gap, 0.0, 1e9);
  requireInRange("cloud_time_offset", cloud_time_offset, -kMaxOffset, kMaxOffset);
  requireInRange("encode_threads", encode_threads, 1, 64);
  requireInRange("max_image_size", max_image_size, 1e-6, 1000.0);  // OpenCV reads up to 2^30 px
  for (std::size_t i = 0; i < cameras.size(); ++i) {
    const std::string name = "camera_" + std::to_string(i) + "/time_offset";
    requireInRange(name.c_str(), cameras[i].time_offset, -kMaxOffset, kMaxOffset);
    require<std::invalid_argument>(cameras[i].model == "camera_info" || cameras[i].isPanorama(), "parameter camera_", i,
                                   "/model = \"", cameras[i].model, "\" must be one of: camera_info, equirectangular");
    const std::string readout = "camera_" + std::to_string(i) + "/readout_time";
    requireInRange(readout.c_str(), cameras[i].readout_time, 0.0, 1.0);
    require<std::invalid_argument>(cameras[i].readout_time == 0 || !cameras[i].isPanorama(), "parameter ", readout,
                                   " has no meaning for a panorama, whose rows come from several sensors");
    const std::string bits = "camera_" + std::to_string(i) + "/bits";
    if (cameras[i].bits != 0) requireInRange(bits.c_str(), cameras[i].bits, 9, 16);
    cameras[i].toldQuantity().check();
    require<std::invalid_argument>(cameras[i].kind == ImageKind::kColor || !cameras[i].isPanorama(),
                                   "parameter camera_", i,
                                   "/kind must be color for a panorama, of which the faces of a cube are kept");
  }
  record.check();
}

std::string CollectorStats::whyNoPoints() const {
  if (cloud.received == 0) return "no cloud came";
  const bool any = cloud.count(Outcome::kKept) + cloud.count(Outcome::kRecordedBefore) > 0;
  if (!any) return "no cloud could be recorded, " + whyNothingKept(cloud, tf_stamps, "cloud_time_offset");
  const std::size_t most = std::max({points.too_far, points.too_near, points.not_finite});
  std::ostringstream out;
  out << "no point of " << cloud.received << " clouds could be recorded, ";
  if (most == 0) {
    out << "they have none";
  } else if (most == points.too_far) {
    out << most << " are farther away than max_range; are they in millimetres? Else raise max_range";
  } else if (most == points.too_near) {
    out << most << " are nearer than min_range; lower it";
  } else {
    out << most << " are not finite or (0, 0, 0)";
  }
  return out.str();
}

std::string CollectorStats::whyNoViews() const {
  std::string text = cameras.empty() ? "there is no camera" : "no image could be recorded";
  for (std::size_t i = 0; i < cameras.size(); ++i) {
    const std::string name = "camera_" + std::to_string(i);
    text += "; " + name + ": ";
    text += cameras[i].received == 0 ? "no image came"
                                     : whyNothingKept(cameras[i], tf_stamps, (name + "/time_offset").c_str());
  }
  return text;
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
