// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause

/// evaluate visible: what a camera certainly saw, and the share of it that got a colour.
#include <ros/time.h>

#include <cmath>
#include <deque>
#include <iostream>

#include "apps/bag_recording.hpp"
#include "apps/evaluate_commands.hpp"
#include "apps/recording_folder.hpp"
#include "cloud_colorizer/cloud/cloud_io.hpp"
#include "cloud_colorizer/ros/params.hpp"
#include "evaluation/table.hpp"
#include "evaluation/visible.hpp"

namespace cloud_colorizer {
namespace {

/// Meets the views with the scans of their moments as both come from a bag. A view waits for the first scan after it;
/// what lies before the first or after the last scan has none.
class Moments {
 public:
  explicit Moments(const VisibleReturns& map) : map_(map) {}

  void addScan(double stamp, Eigen::Matrix3Xd in_map) {
    scans_.push_back({stamp, std::move(in_map)});
    countViews();
    // A view comes at most `tf_wait` s after its scan, but the images of one moment may be encoded for longer.
    while (scans_.size() > kKept) scans_.pop_front();
  }

  void addView(const View& view, const Intrinsics& intrinsics) {
    views_.push_back({view, intrinsics});
    countViews();
  }

  const VisibleCounts& counts() const { return counts_; }

 private:
  static constexpr std::size_t kKept = 50;
  struct Scan {
    double stamp;
    Eigen::Matrix3Xd in_map;
  };
  struct Waiting {
    View view;
    Intrinsics intrinsics;
  };

  void countViews() {
    std::deque<Waiting> waiting;
    for (const Waiting& at : views_) {
      if (scans_.empty() || scans_.back().stamp < at.view.stamp) {
        waiting.push_back(at);
      } else if (scans_.front().stamp <= at.view.stamp) {
        const Camera camera = Camera(at.intrinsics).whileMoving(at.view.readout_motion);
        counts_.add(map_.count(nearest(at.view.stamp).in_map, camera, at.view.map_from_camera));
      }
    }
    views_ = std::move(waiting);
  }

  const Scan& nearest(double stamp) const {
    return *std::min_element(scans_.begin(), scans_.end(), [&](const Scan& a, const Scan& b) {
      return std::abs(a.stamp - stamp) < std::abs(b.stamp - stamp);
    });
  }

  const VisibleReturns& map_;
  std::deque<Scan> scans_;
  std::deque<Waiting> views_;
  VisibleCounts counts_;
};

void scoreBag(const CommandLine& line, const Cloud& map, const std::string& file, const Callbacks& callbacks) {
  const VisibleReturns returns(map, file, line.value("max-distance", 0.0));
  Moments moments(returns);
  CollectorEvents events;
  events.cloud_kept = [&](const Cloud& cloud, const Eigen::Isometry3d& map_from_sensor, double stamp) {
    moments.addScan(stamp, map_from_sensor * cloud.positions);
  };
  events.view_kept = [&](std::size_t, const View& view, const Intrinsics& intrinsics, const SharedBytes&) {
    moments.addView(view, intrinsics);
  };
  const RecordingFolder scratch("", file, callbacks);
  const std::vector<std::string> bags(line.positionals.begin(), line.positionals.end() - 1);
  recordBags(line, bags, scratch.path(), events, callbacks);
  std::cout << "returns in the images of their moments, in " << moments.counts().describe() << " (points within "
            << formatNumber(returns.maxDistance(), 3) << " m)\n";
}

}  // namespace

int runVisible(int argc, char** argv) {
  ros::Time::init();
  CommandSpec spec;
  spec.program = "evaluate visible";
  spec.summary =
      "Of what a camera certainly saw, the share that got a colour: returns of a scan of a bag that fall into the "
      "image of that moment, or, without a bag, the points whose field `seen` is above 0.";
  spec.positionals = "[DRIVE.bag ...] RESULT";
  spec.min_positionals = 1;
  spec.max_positionals = 100000;
  spec.options = {
      kConfigOption,
      {"max-distance", "M", "from a return to its point of the result (3 times the distance between points)"}};
  spec.other_params = describeCollectorParams(CollectorParams());
  return runMain(argc, argv, spec, [](const CommandLine& line, const Callbacks& callbacks) {
    const std::string& file = line.positionals.back();
    CloudReader reader(file);
    const Cloud map = reader.read(reader.numPoints());
    if (line.positionals.size() > 1) {
      scoreBag(line, map, file, callbacks);
    } else {
      std::cout << "points by their field seen: " << countSeen(map, file).describe() << "\n";
    }
  });
}

}  // namespace cloud_colorizer
