// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause
#include "ros/transform_buffer.hpp"

#include <tf2/exceptions.h>
#include <tf2_eigen/tf2_eigen.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <sstream>

#include "base/text.hpp"

namespace cloud_colorizer {
namespace {

using Isometry = Eigen::Isometry3d;

constexpr double kMaxDistance = 1e9;  // m from the map's origin; up to there a double is exact to a micrometre
constexpr std::array kScanners = {"lidar", "velodyne", "livox", "ouster", "os_sensor", "hesai", "rslidar", "laser"};
constexpr double kSlack = 0.001;  // s by which stamps of a steady rate differ

/// Without the rotation's last digits, which tf takes a percent off the unit length, and tf2_eigen as well.
Isometry isometryOf(geometry_msgs::Transform transform) {
  Eigen::Quaterniond rotation;
  tf2::fromMsg(transform.rotation, rotation);
  transform.rotation = tf2::toMsg(rotation.normalized());
  return tf2::transformToEigen(transform);
}

/// More than two roundings of one calibration differ.
bool differs(const Isometry& a, const Isometry& b) {
  const double distance = (a.translation() - b.translation()).norm();
  const double angle = Eigen::AngleAxisd(a.linear().transpose() * b.linear()).angle();
  return angle > 1e-3 || distance > 0.01 * std::max(a.translation().norm(), b.translation().norm());
}

std::string describeDifference(const Isometry& a, const Isometry& b) {
  std::ostringstream out;
  out.precision(3);
  out << (a.translation() - b.translation()).norm() << " m and "
      << Eigen::AngleAxisd(a.linear().transpose() * b.linear()).angle() * 180 / M_PI << " degrees";
  return out.str();
}

}  // namespace

std::string withoutSlash(const std::string& frame) {
  return !frame.empty() && frame.front() == '/' ? frame.substr(1) : frame;
}

TransformBuffer::TransformBuffer(double cache, double max_gap, const Stillness& stillness)
    : buffer_(ros::Duration(cache)), cache_(cache), max_gap_(max_gap), stillness_(stillness) {}

std::string TransformBuffer::add(const geometry_msgs::TransformStamped& transform, bool is_static) {
  const std::string &child = transform.child_frame_id, &parent = transform.header.frame_id;
  const ros::Time stamp = transform.header.stamp;
  std::string warning;
  const auto [entry, is_new] = edges_.try_emplace(child);
  Edge& edge = entry->second;
  const Isometry pose = isometryOf(transform.transform);
  if (!is_new && !edge.warned) {
    if (edge.parent != parent) {
      warning = "frame " + child + " has two parents, " + edge.parent + " and " + parent +
                ", and tf can use one at a time; leave out the publisher that is not wanted";
    } else if (is_static && edge.is_static && differs(edge.transform, pose)) {
      warning = "two static transforms from " + parent + " to " + child + " contradict each other by " +
                describeDifference(edge.transform, pose) + "; the one that came last counts";
    }
    edge.warned = !warning.empty();
  }
  const bool is_repeated = !is_new && edge.is_static == is_static && edge.parent == parent &&
                           (is_static ? edge.transform.matrix() == pose.matrix()
                                      : std::binary_search(edge.stamps.begin(), edge.stamps.end(), stamp));
  if (is_repeated) return warning;
  if (!buffer_.setTransform(transform, "tf", is_static)) {  // tells what it refuses
    if (is_new) edges_.erase(entry);
    return warning;
  }
  edge.parent = parent;
  edge.is_static = is_static;
  edge.transform = pose;
  names_.insert({child, parent});
  if (!is_static) {
    edge.stamps.insert(std::upper_bound(edge.stamps.begin(), edge.stamps.end(), stamp), stamp);
    while (edge.stamps.back().toSec() - edge.stamps.front().toSec() > cache_) edge.stamps.pop_front();
  }
  return warning;
}

Isometry TransformBuffer::lookUp(const std::string& target, const std::string& source, ros::Time stamp) const {
  if (target == source) return Isometry::Identity();
  try {
    Isometry result = isometryOf(buffer_.lookupTransform(target, source, stamp).transform);
    if (!(result.translation().cwiseAbs().maxCoeff() < kMaxDistance)) {  // tf takes infinity
      throw Refused{Outcome::kNoTransform, "the transform from " + source + " to " + target +
                                               " is damaged: a translation of " +
                                               std::to_string(result.translation().norm()) + " m"};
    }
    checkGaps(target, source, stamp);
    return result;
  } catch (const tf2::ConnectivityException& error) {
    throw NotYet{{Outcome::kNoTransform, std::string(error.what()) + " Is map_frame (" + target + ") right?"}};
  } catch (const tf2::LookupException&) {
    throw NotYet{{Outcome::kNoTransform, whyUnknown(target, source)}};
  } catch (const std::runtime_error& error) {  // tf2's, and ros::Duration's where stamps are 68 years apart
    throw NotYet{{Outcome::kNoTransform, error.what()}};
  }
}

std::set<std::string> TransformBuffer::wayToRoot(const std::string& frame) const {
  std::set<std::string> children;
  for (auto edge = edges_.find(frame); edge != edges_.end(); edge = edges_.find(edge->second.parent)) {
    if (!children.insert(edge->first).second) break;  // tf refuses loops, but parents may change
  }
  return children;
}

void TransformBuffer::checkGaps(const std::string& target, const std::string& source, ros::Time stamp) const {
  if (max_gap_ <= 0) return;
  const std::set<std::string> from = wayToRoot(source), to = wayToRoot(target);
  std::vector<std::string> way;
  std::set_symmetric_difference(from.begin(), from.end(), to.begin(), to.end(), std::back_inserter(way));
  for (const std::string& child : way) {
    const std::deque<ros::Time>& stamps = edges_.at(child).stamps;
    const auto after = std::lower_bound(stamps.begin(), stamps.end(), stamp);
    if (after == stamps.begin() || after == stamps.end() || *after == stamp) continue;
    const double gap = after->toSec() - std::prev(after)->toSec();
    if (gap <= max_gap_ + kSlack || standsStill(child, *std::prev(after), *after)) continue;
    std::ostringstream text;
    text << "tf of " << child << " has a gap of " << gap << " s, longer than tf_max_gap = " << max_gap_
         << "; raise it if the pose may be interpolated over that time";
    throw Refused{Outcome::kNoTransform, text.str()};
  }
}

bool TransformBuffer::standsStill(const std::string& child, ros::Time before, ros::Time after) const {
  const std::string& parent = edges_.at(child).parent;
  const Isometry first = isometryOf(buffer_.lookupTransform(parent, child, before).transform);
  const Isometry moved = first.inverse() * isometryOf(buffer_.lookupTransform(parent, child, after).transform);
  const double angle = Eigen::AngleAxisd(moved.linear()).angle() * 180 / M_PI;
  return moved.translation().norm() <= stillness_.distance && angle <= stillness_.angle;
}

std::string TransformBuffer::frames() const {
  std::string text;
  for (const std::string& name : names_) text += (text.empty() ? "" : ", ") + name;
  return text;
}

std::string TransformBuffer::scannerFrame() const {
  std::string found;
  for (const std::string& name : names_) {
    const std::string lower = lowerCase(name);
    const bool is_scanner = std::any_of(kScanners.begin(), kScanners.end(),
                                        [&](const char* word) { return lower.find(word) != std::string::npos; });
    if (!is_scanner) continue;
    if (!found.empty()) return {};
    found = name;
  }
  return found;
}

std::string TransformBuffer::whyUnknown(const std::string& target, const std::string& source) const {
  if (names_.empty()) return "there is no tf at all";
  if (has(target)) return "tf has no frame " + source + "; it has the frames " + frames();
  return "map_frame is " + target + ", but tf has the frames " + frames() + "; set map_frame to one of them";
}

void TransformBuffer::clear() {
  buffer_.clear();
  for (auto& [child, edge] : edges_) edge.stamps.clear();
}

}  // namespace cloud_colorizer
