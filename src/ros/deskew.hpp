// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause

/// A spinning LiDAR measures for a tenth of a second while its vehicle moves on. Where the points tell when they were
/// measured, the motion can be undone; where a driver or a mapping program did so already, it must not be done twice.
#pragma once

#include <Eigen/Geometry>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "cloud_colorizer/base/types.hpp"
#include "cloud_colorizer/cloud/cloud.hpp"

namespace cloud_colorizer {

/// When each point of a cloud was measured.
struct PointTimes {
  std::string field, unit;     ///< "t", "ns"
  std::vector<float> seconds;  ///< after the cloud's stamp; one a point
  float first = 0, last = 0;   ///< of them
};

/// Of a field time, t, timestamp, offset_time or the like: after the stamp [s since 1970], or since 1970, or by another
/// clock (then the first point is at the stamp). Its unit is that in which a sweep takes between 4 ms and 4 s. Empty
/// where there is no such field, or it does not tell of a sweep.
std::optional<PointTimes> pointTimes(const Cloud& cloud, double stamp);

/// How a sensor moved during a sweep.
class SweepMotion {
 public:
  /// `pose` gives map_from_sensor so many seconds after the stamp; what it throws passes through.
  SweepMotion(const PointTimes& times, const std::function<Eigen::Isometry3d(double seconds)>& pose);

  /// Positions in the sensor's frame of the moment of each point -> of the moment of the stamp.
  Eigen::Matrix3Xd undone(const Eigen::Matrix3Xd& positions, const PointTimes& times) const;
  /// How far the motion displaces points at the median range, as a share of the range.
  double displacement(const Eigen::Matrix3Xd& positions) const;

 private:
  float first_, step_;                     ///< s
  std::vector<Eigen::Quaterniond> turns_;  ///< of the sensor's frames, as the one of the stamp has them
  std::vector<Eigen::Vector3d> places_;
};

/// Compares a part of the map with itself: as the clouds came, and with their motion undone.
class DeskewTrial {
 public:
  /// Points of one cloud in the map frame.
  void add(const Eigen::Matrix3Xd& as_they_came, const Eigen::Matrix3Xd& undone);
  std::size_t numClouds() const { return num_clouds_; }

  struct Verdict {
    bool is_certain = false;  ///< one of both is clearly thinner
    bool is_undone_better = false;
    float thickness = 0, thickness_undone = 0;  ///< m, median
  };
  Verdict verdict() const;

 private:
  std::size_t num_clouds_ = 0;
  std::optional<Eigen::Vector3d> origin_;
  std::vector<Eigen::Vector3f> came_, undone_;
};

/// A cloud whose points may tell when they were measured.
struct Sweep {
  Cloud cloud;
  double stamp = 0;  ///< s since 1970
  /// map_from_sensor so many seconds after the stamp. Throws NotYet, Refused.
  std::function<Eigen::Isometry3d(double seconds)> pose;
};

/// The clouds that wait, the first of them being the next to be recorded.
struct WaitingSweeps {
  std::size_t count = 0;
  std::function<double(std::size_t)> stamp;  ///< s since 1970
  std::function<Sweep(std::size_t)> read;    ///< throws NotYet, Refused
};

/// Undoes the motion of clouds, if that makes the map thinner: `auto` tries it on the first clouds of a vehicle that
/// moves, before they are recorded, and leaves them as they are where they do not tell.
class Deskewer {
 public:
  using Log = std::function<void(LogLevel, const std::string&)>;

  Deskewer(const std::string& mode, Log log);  ///< auto, on or off

  /// The first of the waiting clouds, which is `sweep`. Throws NotYet while more must come, if it `may_wait`.
  void apply(Sweep& sweep, const WaitingSweeps& waiting, bool may_wait);
  void startAnew();  ///< as time jumped back; what is decided stays
  /// Whether apply() would throw once more, as no cloud has come since; the newest one has this stamp.
  bool waitsFor(double newest_stamp) const { return is_waiting_ && newest_stamp <= waiting_at_; }

 private:
  enum class State { kUndecided, kUndone, kAsTheyCame };

  void tryOut(const Sweep& sweep, const PointTimes& times, const WaitingSweeps& waiting, bool may_wait);
  void lookAhead(const WaitingSweeps& waiting);
  void decide(const PointTimes& times);

  Log log_;
  State state_;
  DeskewTrial trial_;
  int num_trials_ = 0;
  bool is_waiting_ = false;
  double waiting_at_ = 0;                                         ///< s since 1970, the newest cloud then
  double looked_until_ = 0, sampled_at_ = 0, settled_until_ = 0;  ///< s since 1970
};

}  // namespace cloud_colorizer
