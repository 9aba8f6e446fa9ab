// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause
#include "evaluation/heldout.hpp"

#include <algorithm>
#include <mutex>

#include "base/columns.hpp"
#include "base/parallel.hpp"
#include "base/progress.hpp"
#include "cloud_colorizer/base/check.hpp"
#include "cloud_colorizer/map/colorize.hpp"
#include "evaluation/block_shifts.hpp"
#include "evaluation/clouds.hpp"
#include "evaluation/heldout_errors.hpp"
#include "evaluation/heldout_pictures.hpp"
#include "evaluation/refine_pose.hpp"
#include "evaluation/trajectory.hpp"
#include "recording/scan_times.hpp"

namespace cloud_colorizer {
namespace {

using Eigen::Index;

std::vector<std::size_t> colorsOnly(const Recording& recording, std::vector<std::size_t> views) {
  const auto is_other = [&](std::size_t view) { return recording.quantityOf(view).kind != ImageKind::kColor; };
  views.erase(std::remove_if(views.begin(), views.end(), is_other), views.end());
  return views;
}

ColoredMap colorMap(const Recording& training, const HeldoutParams& params, Method method, const Callbacks& callbacks) {
  Params settings = params.params;
  settings.colorize.method = method;
  settings.colorize.uncolored = Uncolored::kKeep;
  colorize(training, settings, callbacks);
  ColoredMap map;
  map.method = enumNames(method)[static_cast<std::size_t>(method)];
  map.poses = usedPoses(training, settings);
  map.points.resize(3, static_cast<Index>(training.numPoints()));
  map.colors.resize(3, map.points.cols());
  Index next = 0;
  forEachColoredTile(training, settings, true, [&](const Cloud& cloud) {
    const ColoredCloud tile = coloredCloud(cloud, training.directory());
    require(next + tile.colors.cols() <= map.points.cols(), "the coloured map has more points than the recording");
    map.points.middleCols(next, tile.colors.cols()) = tile.positions.cast<float>();
    map.colors.middleCols(next, tile.colors.cols()) = tile.colors;
    next += tile.colors.cols();
    for (const std::uint16_t count : tile.count) map.colored.push_back(count > 0 ? 1 : 0);
  });
  require(next == map.points.cols(), "the coloured map has ", next, " points, the recording ", map.points.cols());
  return map;
}

/// Of all points of the map.
std::string coloredShare(const ColoredMap& map) {
  const auto colored = std::count(map.colored.begin(), map.colored.end(), 1);
  return formatNumber(static_cast<double>(colored) / static_cast<double>(map.colored.size()), 4);
}

/// The views of a recording that maps were coloured without, and the maps.
class Heldout {
 public:
  Heldout(const Recording& recording, const HeldoutParams& params, const std::string& directory,
          const Callbacks& callbacks)
      : recording_(recording),
        params_(params),
        directory_(directory),
        views_(colorsOnly(recording, heldoutViews(recording.views(), params.every))),
        training_(trainingOf()),
        scan_times_(recording.scans()) {
    for (const Method method : params.methods) maps_.push_back(colorMap(training_, params, method, callbacks));
    median_ = std::find_if(maps_.begin(), maps_.end(), [](const ColoredMap& map) { return map.method == "median"; });
    require(median_ != maps_.end(), "the methods must include median, which tells the moved points");
    surfels_ = estimateSurfels(points(), params.params.surfels);
    neighbors_ = shortLinks(points());
  }

  HeldoutResult score(const Callbacks& callbacks) const {
    std::vector<std::vector<HeldoutErrors>> errors(views_.size());
    std::mutex mutex;
    ProgressMeter meter(callbacks, "held-out views", views_.size());
    parallelFor(params_.params.colorize.num_threads, views_.size(), [&](std::size_t h) {
      errors[h] = scoreView(views_[h]);
      const std::lock_guard<std::mutex> lock(mutex);
      meter.add(1, false);
    });
    HeldoutResult result;
    result.methods.header = result.views.header = HeldoutErrors::header();
    result.methods.header.emplace_back("colored_share");
    result.views.header.insert(result.views.header.begin(), "view");
    for (std::size_t m = 0; m < maps_.size(); ++m) {
      HeldoutErrors all;
      for (std::size_t h = 0; h < views_.size(); ++h) {
        all.add(errors[h][m]);
        std::vector<std::string> row = errors[h][m].cells(maps_[m].method);
        row.insert(row.begin(), std::to_string(views_[h]));
        result.views.add(row);
      }
      std::vector<std::string> row = all.cells(maps_[m].method);
      row.push_back(coloredShare(maps_[m]));
      result.methods.add(row);
    }
    return result;
  }

 private:
  const Points& points() const { return maps_.front().points; }

  Recording trainingOf() const {
    require(!views_.empty(), "recording ", recording_.directory(), " has ", recording_.views().size(),
            " views, of which --every ", params_.every, " leaves none out; choose a smaller number");
    std::vector<std::size_t> kept;
    for (std::size_t v = 0; v < recording_.views().size(); ++v) {
      if (!std::binary_search(views_.begin(), views_.end(), v)) kept.push_back(v);
    }
    return withViews(recording_, kept, directory_ + "/training");
  }

  std::shared_ptr<const EmptySpace> emptyAt(const View& view) const {
    if (params_.params.record.scan_resolution == 0) return nullptr;
    return emptySpaceAt(recording_, scan_times_, view.stamp, view.map_from_camera, [&](std::size_t scan) {
      return std::make_shared<const ScanRanges>(scanRanges(recording_.readScan(scan)));
    });
  }

  /// Whether the method changed the poses that were recorded; where not, the held-out view keeps its own as well.
  bool isCorrected(const ColoredMap& map) const {
    for (std::size_t v = 0; v < map.poses.size(); ++v) {
      if (map.poses[v].matrix() != training_.views()[v].map_from_camera.matrix()) return true;
    }
    return false;
  }

  /// Of one method, at the points that the view sees; `own` becomes the image from the pose that goes with the map.
  HeldoutErrors compare(const ColoredMap& map, const HeldoutView& view, const SeenImage& seen,
                        const std::vector<std::uint8_t>& moved, SeenImage& own) const {
    const bool is_corrected = isCorrected(map);
    const Eigen::Isometry3d pose =
        is_corrected ? poseOnTrajectory(view.view, training_.views(), map.poses) : view.view.map_from_camera;
    own = is_corrected ? view.from(pose, points(), seen) : seen;
    HeldoutErrors errors = compareWithImage(map, own, moved, neighbors_);
    errors.given = is_corrected ? compareWithImage(map, seen, moved, {}).after_gain : errors.after_gain;
    const SeenImage refined = view.from(refinedPose(map, view, own, pose), points(), own);
    errors.refined = compareWithImage(map, refined, moved, {}).trimmed;
    for (const BlockShift& shift : blockShifts(map, own, view.image)) errors.shifts.push_back(shift.pixels);
    for (const BlockShift& warp : blockShifts(map, refined, view.image)) {
      errors.warps.push_back(warp.pixels);
      errors.shift_errors.push_back(warp.error);
    }
    return errors;
  }

  /// The pose from which the image fits this map best. At it no method pays for the error of the held-out view's own
  /// pose, nor has an advantage when the map moved with a correction of the extrinsics.
  static Eigen::Isometry3d refinedPose(const ColoredMap& map, const HeldoutView& view, const SeenImage& seen,
                                       const Eigen::Isometry3d& start) {
    std::vector<Index> colored;
    for (const Index p : seen.points) {
      if (map.colored[static_cast<std::size_t>(p)] != 0) colored.push_back(p);
    }
    return refinePose(gatherColumns(map.points, colored), gatherColumns(map.colors, colored), view.camera, view.image,
                      start);
  }

  /// One of each method; the last one's pictures are saved.
  std::vector<HeldoutErrors> scoreView(std::size_t number) const {
    const View& recorded = recording_.views()[number];
    const Camera camera = Camera(recording_.cameras()[recorded.camera].intrinsics).whileMoving(recorded.readout_motion);
    const ViewPixels pixels = recording_.readPixels(number);
    const HeldoutView view{recorded, camera, pixels.image, pixels.mask, emptyAt(recorded)};
    const SeenImage seen = view.at(points(), surfels_, params_.params);
    const std::vector<std::uint8_t> moved = movedPoints(*median_, seen, params_.moved_error);
    std::vector<HeldoutErrors> errors;
    SeenImage own;
    const std::vector<Index> measured = view.measured(points());
    for (const ColoredMap& map : maps_) {
      errors.push_back(compare(map, view, seen, moved, own));
      errors.back().countMeasured(map, measured);
    }
    const ColoredMap& last = maps_.back();
    std::vector<std::uint8_t> colored;
    for (const Index p : own.points) colored.push_back(last.colored[static_cast<std::size_t>(p)]);
    savePictures(directory_ + "/view_" + std::to_string(number) + ".png", last.method, own, predict(last, own, true),
                 colored, view.image);
    return errors;
  }

  const Recording& recording_;
  const HeldoutParams& params_;
  const std::string& directory_;
  const std::vector<std::size_t> views_;
  const Recording training_;
  const ScanTimes scan_times_;
  std::vector<ColoredMap> maps_;
  std::vector<ColoredMap>::const_iterator median_;
  Surfels surfels_;
  std::vector<Edge> neighbors_;
};

}  // namespace

HeldoutResult scoreHeldout(const Recording& recording, const HeldoutParams& params, const std::string& directory,
                           const Callbacks& callbacks) {
  params.check();
  return Heldout(recording, params, directory, callbacks).score(callbacks);
}

}  // namespace cloud_colorizer
