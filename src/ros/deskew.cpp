// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause
#include "ros/deskew.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <sstream>

#include "base/robust.hpp"
#include "base/text.hpp"
#include "cloud_colorizer/cloud/cloud.hpp"
#include "cloud_colorizer/surface/surfels.hpp"
#include "ros/transform_buffer.hpp"

namespace cloud_colorizer {
namespace {

constexpr double kShortest = 0.004, kLongest = 4;  // s that a sweep takes
constexpr double kSameClock = 100;                 // s; times since 1970 are not farther from the stamp
constexpr double kKnot = 0.01;                     // s between two poses that are looked up
constexpr std::size_t kMaxKnots = 100;
constexpr double kNoticed = 0.02;  // of the range: less than that a trial cannot tell from the errors of poses
constexpr std::size_t kTrialPoints = 10000;  // of a cloud
constexpr std::size_t kTrialClouds = 5, kLeastClouds = 3;
constexpr double kTrialStep = 0.35;  // s between two of them
constexpr int kMaxTrials = 20;
constexpr float kClear = 0.1F;  // of a thickness: a smaller difference is none
/// So many times more surfels must get thinner than thicker, or the other way round. With errors of poses as vehicles
/// have them, the wrong way reached 1.9 (at 1 to 2 m/s) and the right one 2.2 to 5.9 (at 10 m/s).
constexpr double kMajority = 2.2;

struct Unit {
  const char* name;
  double seconds;
};
constexpr std::array<Unit, 4> kUnits = {{{"s", 1}, {"ms", 1e-3}, {"us", 1e-6}, {"ns", 1e-9}}};

const Field* timeField(const Cloud& cloud, std::size_t& offset) {
  for (const char* name : {"time", "t", "timestamp", "offset_time", "time_offset", "time_stamp", "timestamp_offset",
                           "point_time", "point_time_offset", "ts"}) {
    std::size_t at = 0;
    for (const Field& field : cloud.fields) {
      if (field.count == 1 && lowerCase(field.name) == name) {
        offset = at;
        return &field;
      }
      at += sizeOf(field.type) * field.count;
    }
  }
  return nullptr;
}

const Unit* unitOf(double span) {
  for (const Unit& unit : kUnits) {
    if (span * unit.seconds >= kShortest && span * unit.seconds < kLongest) return &unit;
  }
  return nullptr;
}

Surfels surfelsOf(const std::vector<Eigen::Vector3f>& points) {
  if (points.empty()) return {};
  return estimateSurfels(Eigen::Map<const Points>(points[0].data(), 3, static_cast<Eigen::Index>(points.size())), {});
}

}  // namespace

std::optional<PointTimes> pointTimes(const Cloud& cloud, double stamp) {
  std::size_t offset = 0;
  const Field* field = timeField(cloud, offset);
  const auto count = static_cast<std::size_t>(cloud.positions.cols());
  if (field == nullptr || count == 0) return {};
  const std::size_t stride = recordSize(cloud.fields);
  std::vector<double> values(count);
  for (std::size_t i = 0; i < count; ++i) {
    values[i] = numberAt(cloud.records.data() + i * stride + offset, field->type);
    if (!std::isfinite(values[i])) return {};
  }
  const auto [first, last] = std::minmax_element(values.begin(), values.end());
  const Unit* unit = unitOf(*last - *first);
  if (unit == nullptr) return {};
  double zero = 0;
  if (std::abs(*first * unit->seconds) > kLongest) {
    const bool is_same_clock = std::abs(*first * unit->seconds - stamp) < kSameClock;
    zero = is_same_clock ? stamp / unit->seconds : *first;
  }
  const auto after = [&](double value) { return static_cast<float>((value - zero) * unit->seconds); };
  PointTimes times{field->name, unit->name, std::vector<float>(count), after(*first), after(*last)};
  std::transform(values.begin(), values.end(), times.seconds.begin(), after);
  return times;
}

SweepMotion::SweepMotion(const PointTimes& times, const std::function<Eigen::Isometry3d(double seconds)>& pose)
    : first_(times.first) {
  const double span = times.last - times.first;
  const auto num_steps = std::clamp<std::size_t>(static_cast<std::size_t>(std::ceil(span / kKnot)), 1, kMaxKnots);
  step_ = static_cast<float>(span / static_cast<double>(num_steps));
  const Eigen::Isometry3d stamp_from_map = pose(0).inverse();
  for (std::size_t i = 0; i <= num_steps; ++i) {
    const Eigen::Isometry3d relative = stamp_from_map * pose(first_ + static_cast<double>(i) * step_);
    turns_.emplace_back(relative.linear());
    places_.emplace_back(relative.translation());
  }
}

Eigen::Matrix3Xd SweepMotion::undone(const Eigen::Matrix3Xd& positions, const PointTimes& times) const {
  Eigen::Matrix3Xd result(3, positions.cols());
  const auto last = static_cast<float>(turns_.size() - 1);
  for (Eigen::Index i = 0; i < positions.cols(); ++i) {
    const float at = std::clamp((times.seconds[static_cast<std::size_t>(i)] - first_) / step_, 0.0F, last);
    const auto knot = std::min(static_cast<std::size_t>(at), turns_.size() - 2);
    const double share = static_cast<double>(at) - static_cast<double>(knot);
    const Eigen::Quaterniond turn = turns_[knot].slerp(share, turns_[knot + 1]);
    result.col(i) = turn * positions.col(i) + (1 - share) * places_[knot] + share * places_[knot + 1];
  }
  return result;
}

double SweepMotion::displacement(const Eigen::Matrix3Xd& positions) const {
  std::vector<double> ranges;
  for (Eigen::Index i = 0; i < positions.cols(); ++i) {
    if (positions.col(i).allFinite()) ranges.push_back(positions.col(i).norm());
  }
  if (ranges.empty()) return 0;
  const double range = std::max(median(ranges), 1e-9);
  const double moved = (places_.back() - places_.front()).norm() / range;
  return moved + turns_.front().angularDistance(turns_.back());
}

void DeskewTrial::add(const Eigen::Matrix3Xd& as_they_came, const Eigen::Matrix3Xd& undone) {
  ++num_clouds_;
  const auto stride = std::max<Eigen::Index>(1, as_they_came.cols() / static_cast<Eigen::Index>(kTrialPoints));
  for (Eigen::Index i = 0; i < as_they_came.cols(); i += stride) {
    if (!as_they_came.col(i).allFinite()) continue;
    if (!origin_) origin_ = as_they_came.col(i);
    came_.emplace_back((as_they_came.col(i) - *origin_).cast<float>());
    undone_.emplace_back((undone.col(i) - *origin_).cast<float>());
  }
}

DeskewTrial::Verdict DeskewTrial::verdict() const {
  const Surfels came = surfelsOf(came_), undone = surfelsOf(undone_);
  std::vector<float> thickness, thickness_undone;
  std::size_t thinner = 0, thicker = 0;  // with the motion undone
  for (Eigen::Index i = 0; i < came.radii.size(); ++i) {
    if (came.normals.col(i).isZero() || undone.normals.col(i).isZero()) continue;
    const float a = came.thickness(i), b = undone.thickness(i);
    thickness.push_back(a);
    thickness_undone.push_back(b);
    if (b < (1 - kClear) * a) ++thinner;
    if (a < (1 - kClear) * b) ++thicker;
  }
  Verdict verdict;
  if (thickness.empty()) return verdict;
  const auto [few, many] = std::minmax(thinner, thicker);
  verdict.is_certain = static_cast<double>(many) > kMajority * static_cast<double>(few) &&
                       static_cast<double>(many - few) > kClear * static_cast<double>(thickness.size());
  verdict.is_undone_better = thinner > thicker;
  verdict.thickness = median(std::move(thickness));
  verdict.thickness_undone = median(std::move(thickness_undone));
  return verdict;
}

void Deskewer::apply(Sweep& sweep, const WaitingSweeps& waiting, bool may_wait) {
  if (state_ == State::kAsTheyCame) return;
  const auto times = pointTimes(sweep.cloud, sweep.stamp);
  if (!times) return;
  if (state_ == State::kUndecided) tryOut(sweep, *times, waiting, may_wait);
  if (state_ != State::kUndone) return;
  sweep.cloud.positions = SweepMotion(*times, sweep.pose).undone(sweep.cloud.positions, *times);
}

void Deskewer::tryOut(const Sweep& sweep, const PointTimes& times, const WaitingSweeps& waiting, bool may_wait) {
  if (sweep.stamp <= settled_until_) return;
  try {
    if (SweepMotion(times, sweep.pose).displacement(sweep.cloud.positions) < kNoticed) return;
  } catch (const NotYet&) {
    if (may_wait) throw;
    return;  // the last one of all: as it came
  } catch (const Refused&) {
    return;  // within a gap of tf: as it came, where its own stamp has a pose
  }
  lookAhead(waiting);
  is_waiting_ = trial_.numClouds() < kTrialClouds && may_wait;
  if (is_waiting_) {
    waiting_at_ = waiting.stamp(waiting.count - 1);
    throw NotYet{{Outcome::kNoTransform, "more clouds must come to tell whether their motion is to be undone"}};
  }
  decide(times);
}

void Deskewer::startAnew() {
  trial_ = {};
  is_waiting_ = false;
  looked_until_ = sampled_at_ = settled_until_ = 0;
}

void Deskewer::lookAhead(const WaitingSweeps& waiting) {
  for (std::size_t i = 0; i < waiting.count && trial_.numClouds() < kTrialClouds; ++i) {
    const double stamp = waiting.stamp(i);
    if (stamp <= looked_until_) continue;
    if (stamp >= sampled_at_ + kTrialStep) {
      try {
        const Sweep sweep = waiting.read(i);
        const auto times = pointTimes(sweep.cloud, sweep.stamp);
        const auto motion = times ? std::optional<SweepMotion>(SweepMotion(*times, sweep.pose)) : std::nullopt;
        if (motion && motion->displacement(sweep.cloud.positions) >= kNoticed) {
          const Eigen::Isometry3d map_from_sensor = sweep.pose(0);
          trial_.add(map_from_sensor * sweep.cloud.positions,
                     map_from_sensor * motion->undone(sweep.cloud.positions, *times));
          sampled_at_ = stamp;
        }
      } catch (const NotYet&) {
        return;
      } catch (const Refused&) {
      }
    }
    looked_until_ = stamp;
  }
}

Deskewer::Deskewer(const std::string& mode, Log log)
    : log_(std::move(log)),
      state_(mode == "on"    ? State::kUndone
             : mode == "off" ? State::kAsTheyCame
                             : State::kUndecided) {}

void Deskewer::decide(const PointTimes& times) {
  const DeskewTrial::Verdict verdict = trial_.numClouds() < kLeastClouds ? DeskewTrial::Verdict() : trial_.verdict();
  trial_ = {};
  settled_until_ = looked_until_;
  const bool gives_up = ++num_trials_ >= kMaxTrials;
  if (!verdict.is_certain && !gives_up) return;
  state_ = verdict.is_certain && verdict.is_undone_better ? State::kUndone : State::kAsTheyCame;
  std::ostringstream text;
  text.precision(2);
  text << "field " << times.field << " [" << times.unit << "] tells when a point was measured; the map is "
       << 100 * verdict.thickness << " cm thick as they came and " << 100 * verdict.thickness_undone
       << " cm with the motion undone: " << (state_ == State::kUndone ? "it is undone" : "they are taken as they came")
       << " (deskew)";
  log_(LogLevel::kInfo, text.str());
}

}  // namespace cloud_colorizer
